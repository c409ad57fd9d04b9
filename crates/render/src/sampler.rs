//! Random numbers: Owen-scrambled Sobol' points, four dimensions at a time [Burley 2020].
//!
//! A path takes its numbers in sets of four. All sets of one sample share the sample's index and
//! differ in their scramble, so each set is stratified over the samples of a pixel (padding). Far
//! along a path stratification no longer reduces the variance; those sets are independent hashed
//! numbers, which cost less [Jarzynski and Olano 2020: pcg4d].

use sobol_burley::parts::{self, Int4};

/// Number of stratified sets: the position in the pixel, and light and direction at the first two
/// vertices. With three sets the second vertex loses its stratification, with ten each path costs
/// more and is hardly less noisy.
const STRATIFIED: u32 = 5;

/// Sobol' points by their index, bits reversed: those of the indices below 256 and of their multiples by 256. Each
/// point is the exclusive or of one of either.
const SOBOL: &[[[u32; 4]; 256]; 2] = &tables();
/// Primitive polynomials of the second, third and fourth dimension, each by its degree, its inner coefficients,
/// and the first direction numbers [Joe and Kuo 2008, new-joe-kuo-6.21201].
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];
/// The scrambles of the four dimensions, those of `sobol_burley`.
const SCRAMBLES: [u32; 4] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];
/// The scramble of the index, likewise.
const SCRAMBLE_OF_INDEX: u32 = 0x79c6_8e4a;

/// The random numbers of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    index: u32,
    seed: u32,
    set: u32,
}

/// The length of a sequence, that of the tables [`SOBOL`] of two bytes; later samples start another one.
const LENGTH: u32 = 1 << 16;

impl Sampler {
    /// The sample number `index` of `stream` (a pixel, say) under `seed`.
    pub fn new(seed: u64, stream: u64, index: u32) -> Self {
        let block = u64::from(index / LENGTH);
        let key = mix(seed ^ mix(stream.wrapping_mul(2).wrapping_add(1) ^ (block << 48)));
        Self { index: index % LENGTH, seed: (key >> 32) as u32 ^ key as u32, set: 0 }
    }

    /// The next four numbers in [0, 1).
    #[inline]
    pub fn next4(&mut self) -> [f32; 4] {
        self.set += 1;
        if self.set > STRATIFIED {
            return pcg4d([self.index, self.seed, self.set, 0]).map(unit);
        }
        self.stratified(self.index)
    }

    /// `count` instances of the next set; all of them, of all samples, are stratified together.
    pub(crate) fn next4_each(&mut self, count: u32) -> impl Iterator<Item = [f32; 4]> + use<> {
        self.set += 1;
        let this = *self;
        (0..count).map(move |i| this.stratified(this.index * count + i))
    }

    /// The point number `index` of this set.
    fn stratified(&self, index: u32) -> [f32; 4] {
        let block = u64::from(index / LENGTH) << 32;
        scrambled(index % LENGTH, self.seed ^ (mix(block | u64::from(self.set)) as u32))
    }
}

/// The point number `index` of the sequence that `seed` scrambles: the same as
/// `sobol_burley::sample_4d(index, 0, seed)`, which takes one step for each bit of the index.
#[inline]
fn scrambled(index: u32, seed: u32) -> [f32; 4] {
    let index =
        parts::owen_scramble_rev(index.reverse_bits(), parts::hash(seed ^ SCRAMBLE_OF_INDEX));
    let bytes = index.reverse_bits().to_le_bytes();
    let [low, high] = [0, 1].map(|i| Int4::from(SOBOL[i][bytes[i] as usize]));
    let scramble = Int4::from(SCRAMBLES.map(|s| s ^ seed.wrapping_mul(0x9c8f_2d3b)));
    let point = parts::owen_scramble_int4_rev(low ^ high, parts::hash_int4(scramble));
    point.reverse_bits().to_f32_norm()
}

/// The direction numbers of dimension `dimension`, bits reversed: one for each bit of an index
/// [Joe and Kuo 2008, equation 2].
const fn directions(dimension: usize) -> [u32; 16] {
    let mut reversed = [0; 16];
    let mut numbers = [1u32; 16];
    let mut k = 0;
    while k < 16 {
        if dimension > 0 {
            let (degree, inner, first) = POLYNOMIALS[dimension - 1];
            if k < degree {
                numbers[k] = first[k];
            } else {
                numbers[k] = numbers[k - degree] ^ (numbers[k - degree] << degree);
                let mut i = 1;
                while i < degree {
                    let coefficient = (inner >> (degree - 1 - i)) & 1;
                    numbers[k] ^= (coefficient * numbers[k - i]) << i;
                    i += 1;
                }
            }
        }
        reversed[k] = (numbers[k] << (31 - k)).reverse_bits();
        k += 1;
    }
    reversed
}

const fn tables() -> [[[u32; 4]; 256]; 2] {
    let mut tables = [[[0; 4]; 256]; 2];
    let mut dimension = 0;
    while dimension < 4 {
        let directions = directions(dimension);
        let mut entry = 0;
        while entry < 512 {
            let (table, index) = (entry / 256, entry % 256);
            let mut bit = 0;
            while bit < 8 {
                if index >> bit & 1 == 1 {
                    tables[table][index][dimension] ^= directions[8 * table + bit];
                }
                bit += 1;
            }
            entry += 1;
        }
        dimension += 1;
    }
    tables
}

/// The hash pcg4d: four numbers whose bits depend on all bits of the input.
#[inline]
fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let stir = |[mut x, mut y, mut z, mut w]: [u32; 4]| {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        [x, y, z, w]
    };
    let mixed = stir(v.map(|a| a.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)));
    stir(mixed.map(|a| a ^ (a >> 16)))
}

/// The upper bits as a number in [0, 1).
#[inline]
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The finaliser of splitmix64 [Steele et al. 2014], a bijection with good avalanche.
pub fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_the_library() {
        for index in (0..LENGTH).step_by(7) {
            let seed = mix(u64::from(index)) as u32;
            assert_eq!(scrambled(index, seed), sobol_burley::sample_4d(index, 0, seed), "{index}");
        }
    }

    #[test]
    fn samples_of_a_pixel_are_stratified_in_every_set() {
        for set in 1..=STRATIFIED {
            let mut cells = [0; 16];
            for index in 0..16 {
                let mut sampler = Sampler::new(3, 77, index);
                let u = (0..set).map(|_| sampler.next4()).last().unwrap();
                cells[(u[0] * 16.0) as usize] += 1;
            }
            assert_eq!(cells, [1; 16], "set {set}");
        }
    }

    #[test]
    fn the_numbers_that_are_not_stratified_are_uniform_and_independent() {
        // Means of products of the 4 numbers of a set, and of those of the next: 1/4 if
        // independent.
        let n = 1 << 15;
        let mut sums = [[0.0f64; 8]; 8];
        for index in 0..n {
            let mut sampler = Sampler::new(5, 9, index);
            (0..STRATIFIED).for_each(|_| _ = sampler.next4());
            let (a, b) = (sampler.next4(), sampler.next4());
            let u = [a, b].concat();
            assert!(u.iter().all(|u| (0.0..1.0).contains(u)));
            for (i, j) in (0..64).map(|k| (k / 8, k % 8)) {
                sums[i][j] += f64::from(u[i]) * f64::from(u[j]);
            }
        }
        for (i, j) in (0..64).map(|k| (k / 8, k % 8)) {
            let (mean, expected) =
                (sums[i][j] / f64::from(n), if i == j { 1.0 / 3.0 } else { 0.25 });
            // The standard deviation of one product is 0.30 at most.
            assert!((mean - expected).abs() < 4.5 * 0.30 / f64::from(n).sqrt(), "{i} {j}: {mean}");
        }
    }

    #[test]
    fn seeds_streams_and_blocks_differ() {
        let first = |seed, stream, index| Sampler::new(seed, stream, index).next4();
        assert_ne!(first(0, 0, 0), first(1, 0, 0));
        assert_ne!(first(0, 0, 0), first(0, 1, 0));
        assert_ne!(first(0, 0, 0), first(0, 0, LENGTH));
    }
}
