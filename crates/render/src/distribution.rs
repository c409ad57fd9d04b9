//! Things of which one is drawn by its weight.
//!
//! A number in [0, 1) draws the first entry whose cumulative weight is above it. A guide says where the search for it
//! begins [Chen and Asau 1974], so that a draw reads two or three lines of memory however many entries there are, where a
//! search by halves would read one for each of its first steps.

/// Entries of a slice of the guide on average. With half of them the guide of a large panorama takes twice the memory, with
/// double of them a search reads a second line.
const PER_SLICE: usize = 4;

/// A discrete distribution.
#[derive(Clone, Debug)]
pub(crate) struct Distribution<T> {
    entries: Vec<Entry<T>>,
    /// For each of equal slices of [0, 1): the entry at its beginning.
    guide: Vec<u32>,
}

/// One of the things.
#[derive(Clone, Copy, Debug)]
struct Entry<T> {
    of: T,
    /// The cumulative distribution up to this one; that of the last one is one, or zero if no weight is positive.
    until: f32,
}

impl<T> Default for Distribution<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), guide: Vec::new() }
    }
}

impl<T> Distribution<T> {
    /// Of things, each with its weight.
    pub(crate) fn new(of: impl IntoIterator<Item = (T, f64)>) -> Self {
        let weighted: Vec<(T, f64)> = of.into_iter().collect();
        let total: f64 = weighted.iter().map(|one| one.1).sum();
        let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
        let mut sum = 0.0;
        let entry = |(of, weight): (T, f64)| {
            sum += weight * scale;
            Entry { of, until: sum as f32 }
        };
        let entries: Vec<Entry<T>> = weighted.into_iter().map(entry).collect();
        let slices = entries.len().div_ceil(PER_SLICE);
        let last = entries.len().saturating_sub(1);
        let first = |slice: usize| {
            let begin = slice as f32 / slices as f32;
            entries.partition_point(|entry| entry.until <= begin).min(last) as u32
        };
        Self { guide: (0..slices).map(first).collect(), entries }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The thing at `place`.
    #[inline]
    pub(crate) fn at(&self, place: usize) -> &T {
        &self.entries[place].of
    }

    /// All of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.entries.iter().map(|entry| &entry.of)
    }

    /// All of them; what they weigh stays.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.entries.iter_mut().map(|entry| &mut entry.of)
    }

    /// The place of the one that a number in [0, 1) draws. Panics if there is none.
    #[inline]
    pub(crate) fn place(&self, u: f32) -> usize {
        let last = self.entries.len() - 1;
        let slice = ((u * self.guide.len() as f32) as usize).min(self.guide.len() - 1);
        let mut place = self.guide[slice] as usize;
        // Rounding may have put the number into the slice after its own.
        while place > 0 && self.entries[place - 1].until > u {
            place -= 1;
        }
        while place < last && self.entries[place].until <= u {
            place += 1;
        }
        place
    }

    /// The probability of the one at `place`.
    #[inline]
    pub(crate) fn probability(&self, place: usize) -> f32 {
        self.entries[place].until - self.before(place)
    }

    /// The place of the one that a number in [0, 1) draws, and how far the number lies within its share, 0 to 1.
    #[inline]
    pub(crate) fn draw(&self, u: f32) -> (usize, f32) {
        let place = self.place(u);
        let within = (u - self.before(place)) / self.probability(place).max(f32::MIN_POSITIVE);
        (place, within.clamp(0.0, 1.0))
    }

    #[inline]
    fn before(&self, place: usize) -> f32 {
        if place == 0 { 0.0 } else { self.entries[place - 1].until }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guide_leads_where_a_search_by_halves_does() {
        // Below zero is the first one, whatever it weighs.
        assert_eq!(Distribution::new([((), 0.0), ((), 1.0)]).place(-1e-7), 0);
        // Some weigh nothing, also the first and the last ones; others a thousandth of their neighbours.
        let weight =
            |k: usize| if k % 7 < 2 || k > 490 { 0.0 } else { 10.0f64.powi(-(k as i32 % 4)) };
        let many = Distribution::new((0..500).map(|k| (k, weight(k))));
        let by_halves =
            |u: f32| many.entries.partition_point(|entry| entry.until <= u).min(many.len() - 1);
        let ends = many.entries.iter().flat_map(|entry| [entry.until, entry.until.next_down()]);
        let even = (0..1000).map(|k| k as f32 / 1000.0);
        for u in ends.filter(|u| (0.0..1.0).contains(u)).chain(even).chain([1.0 - f32::EPSILON]) {
            assert_eq!(many.place(u), by_halves(u), "{u}");
            assert!(weight(many.place(u)) > 0.0, "{u}");
        }
    }

    #[test]
    fn shares_are_as_the_weights_and_places_within_them_even() {
        let few = Distribution::new([("a", 1.0), ("b", 0.0), ("c", 3.0)]);
        assert_eq!(few.draw(0.125), (0, 0.5));
        assert_eq!(few.draw(0.25), (2, 0.0));
        assert_eq!(few.draw(0.625), (2, 0.5));
        assert_eq!([0, 1, 2].map(|place| few.probability(place)), [0.25, 0.0, 0.75]);
        // Where none has a weight, the last is drawn: nobody asks.
        assert_eq!(Distribution::new([("a", 0.0), ("b", 0.0)]).place(0.5), 1);
    }
}
