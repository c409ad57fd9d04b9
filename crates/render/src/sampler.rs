//! Owen-scrambled Sobol' points, four dimensions at a time [Burley 2020].
//!
//! A path takes its numbers in sets of four. All sets of one sample share the sample's index and
//! differ in their scramble, so each set is stratified over the samples of a pixel.

/// The numbers of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    index: u32,
    seed: u32,
    set: u32,
}

/// The sequence is this long; later samples start another one.
const LENGTH: u32 = 1 << 16;

impl Sampler {
    /// The sample number `index` of the stream `stream` (a pixel, say) under `seed`.
    pub fn new(seed: u64, stream: u64, index: u32) -> Self {
        let block = u64::from(index / LENGTH);
        let key = mix(seed ^ mix(stream.wrapping_mul(2).wrapping_add(1) ^ (block << 48)));
        Self { index: index % LENGTH, seed: (key >> 32) as u32 ^ key as u32, set: 0 }
    }

    /// The next four numbers in [0, 1).
    #[inline]
    pub fn next4(&mut self) -> [f32; 4] {
        self.set += 1;
        let seed = self.seed ^ (mix(u64::from(self.set)) as u32);
        sobol_burley::sample_4d(self.index, 0, seed)
    }
}

/// A bijection that scatters the bits (the finaliser of splitmix64).
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
        for set in 1..20 {
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
    fn seeds_streams_and_blocks_differ() {
        let first = |seed, stream, index| Sampler::new(seed, stream, index).next4();
        assert_ne!(first(0, 0, 0), first(1, 0, 0));
        assert_ne!(first(0, 0, 0), first(0, 1, 0));
        assert_ne!(first(0, 0, 0), first(0, 0, LENGTH));
    }
}
