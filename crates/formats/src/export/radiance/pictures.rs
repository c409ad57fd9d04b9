//! Pictures over surfaces, in Radiance's words: where a place of a surface lies in one.

use unrender_scene::{Image, Rgb, Wrap};

/// An expression for `coordinate` within the picture, 0 to 1.
pub(super) fn within(coordinate: &str, wrap: Wrap) -> String {
    match wrap {
        Wrap::Repeat => format!("frac({coordinate})"),
        Wrap::MirroredRepeat => format!("(1-abs(2*frac(.5*({coordinate}))-1))"),
        Wrap::ClampToEdge => format!("if({coordinate},if({coordinate}-1,1,{coordinate}),0)"),
    }
}

/// An expression for the place of `within`, 0 to 1, among `texels` texels with one more on each side.
/// Radiance puts the centres of the outermost texels onto the picture's edges.
pub(super) fn place(within: &str, texels: usize, shorter: f32) -> String {
    let side = (texels + 2) as f32 / shorter / (texels + 1) as f32;
    format!("({within}*{texels}+.5)*{side}")
}

/// `image` with the texels that lie around it.
pub(super) fn with_frame(image: &Image<Rgb>, [wrap_u, wrap_v]: [Wrap; 2]) -> Image<Rgb> {
    let (width, height) = (image.width(), image.height());
    Image::from_fn(width + 2, height + 2, |x, y| {
        let column = wrap_u.apply(x as i64 - 1, width);
        *image.at(column, wrap_v.apply(y as i64 - 1, height))
    })
}
