//! Matrix exponentials against SciPy.
//!
//! Recipe (Python 3, SciPy 1.17.1): `scipy.linalg.expm(a)` of the matrices below, printed with `repr(float(x))`; the ones without large
//! entries agree with mpmath's Taylor series in 60 digits to 5e-15.

#![expect(clippy::unreadable_literal, reason = "as SciPy prints them")]

use quell_response::transient::matrix_exponential;

#[rustfmt::skip]
#[test]
fn against_scipy() {
    // Tolerances relative to the largest entry: rounding 1e-16 times the squarings, times what the matrix loses by not being normal.
    type Case = (&'static str, usize, &'static [f64], &'static [f64], f64);
    let cases: [Case; 5] = [
        // one Jordan block
        ("defective", 3,
            &[-1.0, 1.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, -1.0],
            &[0.36787944117144233, 0.3678794411714423, 0.18393972058572114, 0.0, 0.36787944117144233, 0.3678794411714423, 0.0, 0.0, 0.36787944117144233],
            1e-14),
        // decay rates from 1e4 to 1: 14 squarings
        ("stiff", 3,
            &[-10000.0, 3.0, 0.0, 2.0, -1.0, 1.0, 0.0, -1.0, 0.0],
            &[7.5874174759656e-09, 3.791728753265566e-05, 0.00016008795218597127, 2.527819168843708e-05, 0.1263249642830301, 0.5336391463824149, -0.0001067253014573141, -0.5336391463824149, 0.6596439347611611],
            1e-11),
        // C. Moler and C. Van Loan (1978), example 1, whose series cancels without scaling
        ("moler_van_loan", 2,
            &[-49.0, 24.0, -64.0, 31.0],
            &[-0.7357587581447559, 0.5518190996580998, -1.4715175990882672, 1.1036382407155778],
            2e-13),
        // entries over twelve decades
        ("unbalanced", 4,
            &[0.0, 1000000.0, 0.0, 0.0, -4e-06, -0.1, 0.0, 0.001, 0.0, 0.0, 0.0, 1.0, 3.0, 0.0, -9.0, -1.0],
            &[329953.76611291786, 23809921006.467766, -1010626.0088057199, 1544895.3079423525, 4.539446239801187, 327572.77401227114, -13.904057771481176, 21.254399689719698, 4668.373457453913, 336875336.2685731, -14297.942181222894, 21858.056335538688, 64226.66766154178, 4634685923.827058, -196722.50701984824, 300719.33775181166],
            1e-12),
        // norm 2600: eleven squarings
        ("large", 4,
            &[0.0, 4.0, 0.0, 0.0, -400.0, -0.8, 200.0, 0.4, 0.0, 0.0, 0.0, 4.0, 200.0, 0.4, -600.0, -12.0],
            &[-0.07257754916629996, 0.013137705634328738, -0.0010729018727911393, 0.008745690198521837, -0.8764860535067812, -0.0743305212733135, -0.6549682480618393, -0.025996201904923747, -0.024820295001809878, 0.008745690198521842, -0.0002624679064526292, 0.005732311365904622, -0.5879534515569522, -0.025996201904923754, -0.4225621949596015, -0.016584832984314297],
            1e-13),
    ];
    for (name, n, a, expected, tolerance) in cases {
        let found = matrix_exponential(a, n);
        let size = expected.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= tolerance * size, "{name}: {found} {expected}");
        }
    }
}

#[test]
fn what_has_no_exponential() {
    assert!(matrix_exponential(&[f64::NAN], 1)[0].is_nan());
    assert!(matrix_exponential(&[800.0], 1)[0].is_infinite());
    assert_eq!(matrix_exponential(&[], 0), Vec::<f64>::new());
    assert_eq!(matrix_exponential(&[0.0; 4], 2), [1.0, 0.0, 0.0, 1.0]);
}
