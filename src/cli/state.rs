//! The condition of the machine: `--state` and `--load`.

use super::arguments::StateChoice;
use super::findings::Findings;
use super::machine_choice::Chosen;
use super::stop::Stop;
use crate::condition;
use crate::options::ConditionFiles;

/// Reads the condition into the machine and reports what the model needs and it lacks; true if it can be used. Fails if the file cannot be read.
pub(super) fn apply(choice: &StateChoice, chosen: &mut Chosen, findings: &mut Findings) -> Result<bool, Stop> {
    Ok(condition::apply(&ConditionFiles::from(choice), chosen, findings)?)
}

/// Reads the condition into the machine; true if it is valid. Fails if the file cannot be read.
pub(super) fn read(choice: &StateChoice, chosen: &mut Chosen, findings: &mut Findings) -> Result<bool, Stop> {
    Ok(condition::read(&ConditionFiles::from(choice), chosen, findings)?)
}

impl From<&StateChoice> for ConditionFiles {
    fn from(choice: &StateChoice) -> ConditionFiles {
        let StateChoice { state, time, zero_time, zero_at, zero: zeros, load } = choice.clone();
        ConditionFiles { files: state, time_s: time, zero_time_s: zero_time, zero_at, zeros, load }
    }
}
