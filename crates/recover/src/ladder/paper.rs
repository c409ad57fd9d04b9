//! x
use super::State;
use crate::problem::{Options, RecoverError};
use crate::record::{Observer, Termination};
pub(crate) fn climb(
    _state: &mut State<'_>,
    _options: &Options,
    _observer: &mut dyn Observer,
) -> Result<Termination, RecoverError> {
    Ok(Termination::Settled)
}
