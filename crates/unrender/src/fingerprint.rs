//! Whether two renderings are of one scene: a digest of all that the scene is.
//!
//! What is digested is the scene's own text form (`Debug`), which has every number of it to the
//! last bit and grows with it: a field that is added later counts at once.

use sha2::{Digest, Sha256};
use std::fmt::{self, Debug, Write};

/// The first half of SHA-256 over the text form of `value`, in hexadecimal digits.
pub(crate) fn fingerprint(value: &impl Debug) -> String {
    let mut sink = Sink(Sha256::new());
    // The sink takes everything, and the scene's types are derived: neither fails.
    let _ = write!(sink, "{value:?}");
    let digest = sink.0.finalize();
    digest[..16].iter().map(|byte| format!("{byte:02x}")).collect()
}

struct Sink(Sha256);

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::{Group, Material, Rgb, Scene};

    #[test]
    fn a_last_bit_makes_another_scene() {
        let scene = |rho: f32| Scene {
            groups: vec![Group {
                name: "wall".into(),
                material: Material::diffuse(Rgb::splat(rho)),
                emission: Rgb::ZERO,
            }],
            ..Scene::default()
        };
        let of = |rho: f32| fingerprint(&scene(rho));
        assert_eq!(of(0.5), of(0.5));
        assert_ne!(of(0.5), of(0.5f32.next_up()));
        assert_eq!(of(0.5).len(), 32);
    }
}
