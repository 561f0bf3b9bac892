//! `quell layouts`: list or count the layouts of a budget.
