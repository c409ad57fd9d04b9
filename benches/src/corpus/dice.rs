//! Pseudo-random numbers from one seed: the same on every machine, and independent for every
//! purpose.

use unrender::render::sampler::mix;

/// A stream of numbers.
#[derive(Clone, Debug)]
pub(crate) struct Dice {
    key: u64,
    count: u64,
}

impl Dice {
    /// The stream of `seed` for one purpose, independent of other purposes.
    pub(crate) fn new(seed: u64, purpose: &str) -> Self {
        let key = purpose.bytes().fold(mix(seed), |key, byte| mix(key ^ u64::from(byte)));
        Self { key, count: 0 }
    }

    /// The next 64 bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.count += 1;
        mix(self.key ^ mix(self.count))
    }

    /// Evenly in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Evenly in [`low`, `high`).
    pub(crate) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// In [`low`, `high`), evenly in the logarithm.
    pub(crate) fn log_range(&mut self, low: f32, high: f32) -> f32 {
        low * (high / low).powf(self.unit())
    }

    /// True with the probability `share`.
    pub(crate) fn chance(&mut self, share: f32) -> bool {
        self.unit() < share
    }

    /// One of 0 to `count` - 1.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        (self.bits() % count.max(1) as u64) as usize
    }

    /// A whole number of `low..=high`.
    pub(crate) fn count(&mut self, low: usize, high: usize) -> usize {
        low + self.index(high + 1 - low)
    }

    /// One of `items`, with probabilities in proportion to their weights.
    pub(crate) fn weighted<T: Copy>(&mut self, items: &[(T, f32)]) -> T {
        let total: f32 = items.iter().map(|item| item.1).sum();
        let mut left = self.unit() * total;
        for &(item, weight) in items {
            if left < weight {
                return item;
            }
            left -= weight;
        }
        items[items.len() - 1].0
    }

    /// Shuffles `items`; all orders are equally likely.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.index(last + 1));
        }
    }

    /// A number of the standard normal distribution [Box and Muller 1958].
    pub(crate) fn normal(&mut self) -> f32 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f32::consts::TAU * self.unit()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_seed_gives_one_stream_and_purposes_differ() {
        let stream = |seed, purpose| {
            let mut dice = Dice::new(seed, purpose);
            [(); 4].map(|()| dice.bits())
        };
        assert_eq!(stream(3, "light"), stream(3, "light"));
        assert_ne!(stream(3, "light"), stream(4, "light"));
        assert_ne!(stream(3, "light"), stream(3, "shape"));
    }

    #[test]
    fn numbers_are_even_and_normal() {
        let mut dice = Dice::new(1, "test");
        let count = 20_000;
        let mean = (0..count).map(|_| dice.unit()).sum::<f32>() / count as f32;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        let numbers: Vec<f32> = (0..count).map(|_| dice.normal()).collect();
        let variance = numbers.iter().map(|x| x * x).sum::<f32>() / count as f32;
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
        let mut drawn = [0; 2];
        (0..count).for_each(|_| drawn[dice.weighted(&[(0, 1.0), (1, 3.0)])] += 1);
        assert!((drawn[1] as f32 / count as f32 - 0.75).abs() < 0.02, "{drawn:?}");
    }
}
