//! The keys `rungs` and `max_rung`: which hypotheses a group may have.

use unrender_scene::Hypothesis;

/// The hypotheses up to `max`, the simplest first.
pub(crate) fn up_to(max: Hypothesis) -> Vec<Hypothesis> {
    Hypothesis::ALL.into_iter().filter(|rung| *rung <= max).collect()
}

/// The hypotheses that the table `key` allows by a `list`, or by the most complex one, ascending; none
/// if it states neither.
pub(super) fn read(
    key: &str,
    list: Option<&[String]>,
    max: Option<&str>,
) -> Result<Option<Vec<Hypothesis>>, String> {
    match (list, max) {
        (None, None) => Ok(None),
        (None, Some(name)) => {
            let max = name.parse().map_err(|problem| format!("{key}.max_rung: {problem}"))?;
            Ok(Some(up_to(max)))
        }
        (Some(_), Some(_)) => {
            Err(format!("{key}: rungs and max_rung say the same; leave one of them out"))
        }
        (Some([]), None) => Err(format!("{key}.rungs: it is empty; name one hypothesis or more")),
        (Some(names), None) => {
            let rung = |name: &String| name.parse::<Hypothesis>();
            let rungs: Result<Vec<_>, _> = names.iter().map(rung).collect();
            let mut rungs = rungs.map_err(|problem| format!("{key}.rungs: {problem}"))?;
            rungs.sort_unstable();
            rungs.dedup();
            Ok(Some(rungs))
        }
    }
}
