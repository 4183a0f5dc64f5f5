//! `reseflow eval`: a policy against held-out demonstrations, beside the trivial predictors.

use crate::cli::EvalArgs;
use crate::evaluation::{EvalInputs, evaluate};
use crate::learning::find_policy;
use crate::output::{OutputFile, Terminal};

/// Runs the command.
pub(super) fn execute(args: &EvalArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let inputs = EvalInputs {
        checkpoint: find_policy(&args.checkpoint)?,
        data: args.data.clone(),
        episodes: None,
        train_data: args.train_data.clone(),
        steps: args.steps.clone(),
        solver: args.solver.choice(!args.steps.is_empty())?,
        unimodal_d_geo: args.unimodal_d_geo,
        seeds: args.seeds,
        device: args.device.into(),
    };
    let loaded = inputs.load()?;
    let mut read = vec![args.data.as_path(), &inputs.checkpoint];
    read.extend(args.train_data.as_deref());
    let out = OutputFile::claim_apart(&args.out, &read)?;
    let report = evaluate(&inputs, &loaded, terminal)?;
    out.write_json(&report)?;
    terminal.say(report.table());
    terminal.machine(&report)
}
