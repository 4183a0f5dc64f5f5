//! Where faults become exit codes: 2 for what the user gave, 1 for what went wrong in here.

use std::path::Path;

use reseflow_data::DataError;
use reseflow_train::TrainError;

/// Exit code for bad input: a file, an option or a configuration that cannot be used.
pub const EXIT_BAD_INPUT: u8 = 2;
/// Exit code for everything that the user could not have prevented.
pub const EXIT_INTERNAL: u8 = 1;

/// A fault in what the user gave. The message is one sentence: where, what, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadInput(pub String);

/// A [`BadInput`] as an `anyhow` error.
pub fn bad_input(sentence: impl Into<String>) -> anyhow::Error {
    BadInput(sentence.into()).into()
}

/// An error in using the data set `path`, by its name where it is the data's fault; that of the validation episodes is `validation`'s.
pub fn about_data(path: &Path, validation: Option<&Path>, error: anyhow::Error) -> anyhow::Error {
    let sentence = sentence(&error);
    let place = match error.downcast_ref::<TrainError>() {
        Some(
            TrainError::Net(_) | TrainError::Batch { .. } | TrainError::NoData | TrainError::NoActions { .. },
        ) => path,
        Some(TrainError::Validation(_)) => validation.unwrap_or(path),
        _ => return error,
    };
    bad_input(format!("{}: {sentence}", place.display()))
}

/// The exit code that an error leads to.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    // A training that diverges or crashes is nobody's bad input; every other fault of the trainer names what it was given.
    let users_fault = error.chain().any(|cause| {
        let fault = cause.downcast_ref::<TrainError>();
        let refused =
            fault.is_some_and(|fault| !matches!(fault, TrainError::Diverged { .. } | TrainError::Worker));
        refused || cause.is::<BadInput>() || cause.is::<DataError>()
    });
    if users_fault { EXIT_BAD_INPUT } else { EXIT_INTERNAL }
}

/// The whole chain of causes as one line, without saying twice what an outer message already quotes.
pub fn sentence(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let message = cause.to_string();
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        if text.is_empty() {
            text = message;
        } else if !text.contains(&message) {
            text.push_str(": ");
            text.push_str(&message);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn a_fault_of_the_user_keeps_its_exit_code_under_any_context() {
        let error = Err::<(), _>(bad_input("a.npz: no `points`")).context("evaluating").unwrap_err();
        assert_eq!(exit_code(&error), EXIT_BAD_INPUT);
        assert_eq!(sentence(&error), "evaluating: a.npz: no `points`");
        assert_eq!(exit_code(&anyhow::anyhow!("a bug")), EXIT_INTERNAL);
        assert_eq!(exit_code(&TrainError::NoData.into()), EXIT_BAD_INPUT);
        let diverged = TrainError::Diverged { what: "loss", update: 3, shard: 0, windows: Vec::new() };
        assert_eq!(exit_code(&diverged.into()), EXIT_INTERNAL);
    }

    #[test]
    fn a_cause_that_the_message_quotes_is_not_repeated() {
        let source = std::io::Error::new(std::io::ErrorKind::NotFound, "no such file");
        let error = anyhow::Error::from(DataError::Io { path: "a.npz".into(), source });
        assert_eq!(sentence(&error), "a.npz: no such file");
    }
}
