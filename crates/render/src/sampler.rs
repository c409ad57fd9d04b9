//! Random numbers: Owen-scrambled Sobol' points, four dimensions at a time [Burley 2020].
//!
//! A path takes its numbers in sets of four. All sets of one sample share the sample's index and
//! differ in their scramble, so each set is stratified over the samples of a pixel (padding). Far
//! along a path stratification no longer reduces the variance; those sets are independent hashed
//! numbers, which cost less [Jarzynski and Olano 2020: pcg4d].

/// Number of stratified sets: the position in the pixel, and light and direction at the first two
/// vertices. With three sets the second vertex loses its stratification, with ten each path costs
/// more and is hardly less noisy.
const STRATIFIED: u32 = 5;

/// The random numbers of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    index: u32,
    seed: u32,
    set: u32,
}

/// The length of a sequence, that of the tables of `sobol_burley`; later samples start another one.
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
        let seed = self.seed ^ (mix(block | u64::from(self.set)) as u32);
        sobol_burley::sample_4d(index % LENGTH, 0, seed)
    }
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
