//! Shares with confidence intervals, and quantiles.

/// The share of successes and Wilson's interval about it at 95 % [Wilson 1927].
pub(crate) fn share(successes: usize, trials: usize) -> (f64, f64, f64) {
    /// The normal quantile of 97.5 %.
    const Z: f64 = 1.959_964;
    if trials == 0 {
        return (0.0, 0.0, 1.0);
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let centre = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    (p, (centre - half).max(0.0), (centre + half).min(1.0))
}

/// The share and its interval in percent, for the page.
pub(crate) fn text(successes: usize, trials: usize) -> String {
    if trials == 0 {
        return "-".to_owned();
    }
    let (p, low, high) = share(successes, trials);
    format!("{:.1} % ({:.1} to {:.1}) of {trials}", 100.0 * p, 100.0 * low, 100.0 * high)
}

/// The value below which the share `share` of `values` lies; none if there are no values.
pub(crate) fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(at.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_is_that_of_the_tables() {
        let (p, low, high) = share(8, 10);
        assert!((p - 0.8).abs() < 1e-12);
        assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4, "{low} {high}");
        let (_, low, high) = share(20, 20);
        assert!((low - 0.8389).abs() < 1e-4 && high > 0.999, "{low} {high}");
        assert_eq!(share(0, 0), (0.0, 0.0, 1.0));
    }

    #[test]
    fn quantiles_are_values_of_the_sample() {
        let values = [3.0, 1.0, 2.0, 4.0];
        assert_eq!(quantile(&values, 0.5), Some(2.0));
        assert_eq!(quantile(&values, 0.95), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
    }
}
