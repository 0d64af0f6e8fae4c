//! Shards of a batch.

use std::fmt;

use crate::terminal::exit_code::Problem;

/// The `index`-th of `count` parts, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    pub(crate) index: usize,
    pub(crate) count: usize,
}

impl Shard {
    /// Largest number of parts.
    const MAX: usize = 100_000;

    pub(crate) fn parse(text: &str) -> Result<Self, Problem> {
        Self::split(text, "/")
            .ok_or_else(|| Problem::usage(format!("--shard {text}: must be I/N with 1 <= I <= N, for instance 2/8")))
    }

    /// The shard to which a file `summary.I-of-N.json` belongs.
    pub(crate) fn of_summary(file_name: &str) -> Option<Self> {
        Self::split(file_name.strip_prefix("summary.")?.strip_suffix(".json")?, "-of-")
    }

    fn split(text: &str, separator: &str) -> Option<Self> {
        let number = |text: &str| text.parse().ok().filter(|n| (1..=Self::MAX).contains(n));
        let (index, count) = text.split_once(separator)?;
        let shard = Self { index: number(index)?, count: number(count)? };
        (shard.index <= shard.count).then_some(shard)
    }

    /// Every `count`-th, starting with the `index`-th.
    pub(crate) fn part<T>(self, all: Vec<T>) -> Vec<T> {
        all.into_iter().skip(self.index - 1).step_by(self.count).collect()
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-of-{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_batch_make_up_the_whole() {
        let whole: Vec<usize> = (0..10).collect();
        let mut joined: Vec<usize> = (1..=4).flat_map(|index| Shard { index, count: 4 }.part(whole.clone())).collect();
        assert_eq!(Shard::parse("2/4").unwrap().part(whole.clone()), [1, 5, 9]);
        joined.sort_unstable();
        assert_eq!(joined, whole);
    }
}
