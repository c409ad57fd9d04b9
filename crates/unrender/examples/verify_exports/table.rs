//! Tables on the page, each between its heading and the next.

use crate::programs::Row;
use unrender::converted::Conversion;
use unrender::scene::{Material, Scene};

/// The rows of a table: the brightness of each group in both pictures, and the error of its
/// conversion.
pub(crate) fn rows(scene: &Scene, conversions: &[Conversion], rows: &[Row]) -> String {
    let mut text = String::from(
        "| group | surface | pixels | ours | theirs | difference | lobe |\n|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let group = &scene.groups[row.group];
        let mean = |rgb: unrender::scene::Rgb| rgb.element_sum() / 3.0;
        let kind = if group.is_emitter() { "lamp" } else { kind(&group.material) };
        let lobe = if conversions[row.group].material == group.material {
            "exact".to_owned()
        } else {
            format!("{:.1} % off", 100.0 * conversions[row.group].difference)
        };
        text.push_str(&format!(
            "| {} | {kind} | {} | {:.4} | {:.4} | {:.2} % | {} |\n",
            group.name,
            row.pixels,
            mean(row.ours),
            mean(row.theirs),
            100.0 * row.difference(),
            if group.material.is_glossy() { lobe.as_str() } else { "-" }
        ));
    }
    text
}

fn kind(material: &Material) -> &'static str {
    match (material.is_delta(), material.is_glossy(), material.texture.is_some()) {
        (true, ..) => "mirror",
        (_, true, _) if material.alpha_x == material.alpha_y => "isotropic",
        (_, true, _) => "anisotropic",
        (.., true) => "textured",
        _ => "diffuse",
    }
}

/// `page` with the table under the heading `title` replaced, or appended with its heading.
pub(crate) fn replace(page: &str, title: &str, table: &str) -> String {
    let heading = format!("### {title}\n");
    let Some(start) = page.find(&heading) else {
        return format!("{}\n\n{heading}\n{table}", page.trim_end());
    };
    let after = start + heading.len();
    let end = page[after..].find("\n#").map_or(page.len(), |next| after + next + 1);
    let rest = &page[end..];
    let gap = if rest.is_empty() { "" } else { "\n" };
    format!("{}\n{table}{gap}{rest}", &page[..after])
}
