//! The order in which definitions that use each other can be worked out.

/// Sorts `0..dependencies.len()` so that each comes after all that it depends on.
///
/// # Errors
/// A cycle: indices each of which depends on the next, the last on the first.
pub(crate) fn order(dependencies: &[Vec<usize>]) -> Result<Vec<usize>, Vec<usize>> {
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        Unseen,
        Open,
        Done,
    }
    let mut state = vec![State::Unseen; dependencies.len()];
    let mut sorted = Vec::with_capacity(dependencies.len());
    for start in 0..dependencies.len() {
        if state[start] != State::Unseen {
            continue;
        }
        // An explicit stack, since a chain may be as long as the file.
        let mut stack = vec![(start, 0_usize)];
        state[start] = State::Open;
        while let Some((node, next)) = stack.last_mut() {
            let node = *node;
            if let Some(&dependency) = dependencies[node].get(*next) {
                *next += 1;
                match state[dependency] {
                    State::Done => {}
                    State::Unseen => {
                        state[dependency] = State::Open;
                        stack.push((dependency, 0));
                    }
                    State::Open => {
                        return Err(stack
                            .iter()
                            .map(|(node, _)| *node)
                            .skip_while(|&node| node != dependency)
                            .collect());
                    }
                }
            } else {
                state[node] = State::Done;
                sorted.push(node);
                stack.pop();
            }
        }
    }
    Ok(sorted)
}

#[cfg(test)]
mod tests {
    use super::order;

    #[test]
    fn dependencies_come_first() {
        assert_eq!(order(&[vec![1], vec![2], vec![]]), Ok(vec![2, 1, 0]));
    }

    #[test]
    fn cycles_are_given_as_chains() {
        assert_eq!(order(&[vec![1], vec![2], vec![1]]), Err(vec![1, 2]));
        assert_eq!(order(&[vec![0]]), Err(vec![0]));
    }
}
