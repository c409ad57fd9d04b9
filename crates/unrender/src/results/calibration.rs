//! The table of a calibration: every parameter with its standard deviation, and the pairs that were
//! thrown out.

use crate::text_table::table;
use unrender_photo::calibrate::{Calibration, Estimate};

/// The table; `all` is how many pairs or lines, `what`, there were.
pub(crate) fn calibration(calibration: &Calibration, all: usize, what: &str) -> String {
    let [x, y, z] = calibration.eye;
    let [right, down] = calibration.principal_point_px;
    let numbers = [
        ("eye x", "m", 4, x),
        ("eye y", "m", 4, y),
        ("eye z", "m", 4, z),
        ("heading", "deg from -z to +x", 3, calibration.heading_deg),
        ("pitch", "deg upwards", 3, calibration.pitch_deg),
        ("roll", "deg, right side up", 3, calibration.roll_deg),
        ("focal length", "px", 1, calibration.focal_px),
        ("field of view", "deg, vertical", 3, calibration.fov_y_deg),
        ("principal point x", "px from the left", 2, right),
        ("principal point y", "px from the top", 2, down),
        ("k1", "", 5, calibration.k1),
        ("k2", "", 5, calibration.k2),
    ];
    let mut rows = vec![["number", "value", "std", "unit"].map(str::to_owned)];
    rows.extend(numbers.map(|(name, unit, digits, estimate)| {
        let Estimate { value, std } = estimate;
        let std = std.map_or_else(|| "held".to_owned(), |std| format!("{std:.digits$}"));
        [name.to_owned(), format!("{value:.digits$}"), std, unit.to_owned()]
    }));
    let mut text = table(&rows);
    let out = &calibration.rejected;
    text.push_str(&format!(
        "{} of {all} {what}, {:.2} px rms ({:.2} px in each coordinate)\n",
        all - out.len(),
        calibration.rms_px,
        calibration.sigma_px
    ));
    for pair in out {
        let off = if pair.distance_px.is_finite() {
            format!("{:.1} px off", pair.distance_px)
        } else {
            "behind the camera".to_owned()
        };
        text.push_str(&format!("thrown out: {}, {off}\n", pair.name));
    }
    text
}
