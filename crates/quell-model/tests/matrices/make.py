"""Makes the matrix files beside it: `python make.py` with NumPy and SciPy (made with NumPy 2.x, SciPy 1.1x).

The files are the reference: NumPy and SciPy wrote them, our readers must find the same numbers.
Entry (i, j) of GENERAL is 10*i + j + 0.5 (from 1), so that a transposed or shifted reading shows.
"""

import numpy as np
import scipy.io
import scipy.sparse

GENERAL = np.array([[10.0 * i + j + 0.5 for j in (1, 2, 3)] for i in (1, 2, 3)])
WIDE = GENERAL[:2, :]
SYMMETRIC = np.array([[4.0, -1.0, 0.0], [-1.0, 5.0, -2.25], [0.0, -2.25, 6.0]])
SKEW = np.array([[0.0, -1.5, 0.0], [1.5, 0.0, 2.0], [0.0, -2.0, 0.0]])
WHOLE = np.array([[1, -2], [3, 2**40]])

np.save("general_c_f8.npy", GENERAL)
np.save("general_fortran_f8.npy", np.asfortranarray(GENERAL))
np.save("wide_c_f4.npy", WIDE.astype(np.float32))
np.save("wide_fortran_f4.npy", np.asfortranarray(WIDE.astype(np.float32)))
np.save("general_big_endian_f8.npy", GENERAL.astype(">f8"))
np.save("whole_i8.npy", WHOLE.astype(np.int64))
np.save("whole_i4.npy", np.array([[1, -2], [3, 4]], dtype=np.int32))
np.save("complex.npy", GENERAL + 1j)
np.save("three_axes.npy", np.zeros((2, 2, 2)))
np.save("not_a_number.npy", np.array([[1.0, np.nan], [0.0, 1.0]]))
np.savez("several.npz", M=SYMMETRIC, K=np.asfortranarray(GENERAL))
np.savez_compressed("one_compressed.npz", M=SYMMETRIC)
scipy.sparse.save_npz("sparse.npz", scipy.sparse.csr_matrix(SYMMETRIC))

scipy.io.mmwrite("general_array.mtx", GENERAL, symmetry="general")
scipy.io.mmwrite("wide_array.mtx", WIDE)
scipy.io.mmwrite("symmetric_array.mtx", SYMMETRIC, symmetry="symmetric")
scipy.io.mmwrite("skew_array.mtx", SKEW, symmetry="skew-symmetric")
scipy.io.mmwrite("symmetric_coordinate.mtx", scipy.sparse.coo_matrix(SYMMETRIC), symmetry="symmetric")
scipy.io.mmwrite("skew_coordinate.mtx", scipy.sparse.coo_matrix(SKEW), symmetry="skew-symmetric")
scipy.io.mmwrite("general_coordinate.mtx", scipy.sparse.coo_matrix(GENERAL), symmetry="general")
scipy.io.mmwrite("whole_coordinate.mtx", scipy.sparse.coo_matrix(WHOLE), symmetry="general")
scipy.io.mmwrite("pattern.mtx", scipy.sparse.coo_matrix(SYMMETRIC), field="pattern")
scipy.io.mmwrite("complex.mtx", GENERAL + 1j)

np.savetxt("general.csv", GENERAL, delimiter=",", header="entry (i, j) is 10*i + j + 0.5")
np.savetxt("general_semicolon.csv", GENERAL, delimiter=";")
np.savetxt("general_blanks.txt", GENERAL)
