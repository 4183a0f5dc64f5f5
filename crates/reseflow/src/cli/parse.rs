//! From the process's arguments to [`Cli`], or to the one sentence that says what is wrong with them.

use std::ffi::OsString;
use std::io::IsTerminal;

use clap::Parser;
use clap::error::ErrorKind;

use super::Cli;

/// What the arguments ask for.
pub enum Parsed {
    /// A command.
    Run(Box<Cli>),
    /// Help or the version: text for standard output.
    Help(String),
    /// Nothing, because they are wrong: one sentence.
    Wrong(String),
}

/// Reads the process's arguments, the program's name first.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Parsed {
    match Cli::try_parse_from(arguments) {
        Ok(cli) => Parsed::Run(Box::new(cli)),
        Err(error) => match error.kind() {
            ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                let text = error.render();
                Parsed::Help(if std::io::stdout().is_terminal() {
                    text.ansi().to_string()
                } else {
                    text.to_string()
                })
            }
            _ => Parsed::Wrong(one_sentence(&error.render().to_string())),
        },
    }
}

/// clap's message without the usage and the pointer to `--help`, on one line.
fn one_sentence(rendered: &str) -> String {
    let end = rendered
        .find("\nUsage:")
        .or_else(|| rendered.find("\nFor more information"))
        .unwrap_or(rendered.len());
    let text = rendered[..end].trim_start_matches("error:");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(line: &str) -> String {
        match parse(line.split(' ').map(OsString::from)) {
            Parsed::Wrong(sentence) => sentence,
            _ => panic!("{line} was accepted"),
        }
    }

    #[test]
    fn the_calls_of_the_contract_are_understood() {
        for line in [
            "reseflow gen --task triangle --episodes 3 --seed 1 --split test --out a.npz",
            "reseflow gen --task door --episodes 3 --seed 1 --out a.npz",
            "reseflow inspect a.npz --json",
            "reseflow predict --checkpoint d --data a.npz --steps 1 --seeds 10 --out p.npz",
            "reseflow eval --checkpoint d --data a.npz --steps 1,2,10,50,100 --seeds 10 --out e.json",
            "reseflow rollout --policy expert --task triangle --episodes 5 --seed 1 --steps 1 --mcap l.mcap --out r.json",
            "reseflow rollout --policy runs/x --task triangle --episodes 5 --seed 1 --steps 1 --split wide --out r.json",
            "reseflow train --config c.toml --data a.npz --validation v.npz --out d --set train.batch_size=8",
            "reseflow reflow --config c.toml --checkpoint d --data a.npz --out e --set reflow.mixture.pair_share=1",
            "reseflow run configs/quickstart.toml --device cpu --set name=x",
            "reseflow bench --checkpoint d --data a.npz --steps 1,10 --solver heun --json",
            "reseflow bench runs/a runs/b",
            "reseflow equiv --checkpoint d --data a.npz --steps 1,10 --seeds 3 --at-most 1e-4 --out e.json",
        ] {
            assert!(matches!(parse(line.split(' ').map(OsString::from)), Parsed::Run(_)), "{line}");
        }
    }

    #[test]
    fn wrong_arguments_are_one_sentence() {
        let cases = [
            ("reseflow gen --task triangle --episodes 0 --seed 1 --out a.npz", "--episodes"),
            (
                "reseflow gen --task triangle --episodes 3 --seed 1 --split tets --out a.npz",
                "similar value exists: 'test'",
            ),
            ("reseflow eval --checkpoint d --data a.npz --steps 1,0 --out e.json", "--steps"),
            ("reseflow predict --checkpoint d --data a.npz --steps 1 --seeds 0 --out p.npz", "--seeds"),
            ("reseflow inspect a.npz --jsn", "'--json'"),
            ("reseflow bench --checkpoint d", "--data"),
            ("reseflow equiv --checkpoint d --data a.npz --at-most 0", "--at-most"),
            ("reseflow bench --data a.npz", "--checkpoint"),
            ("reseflow bench runs/a --checkpoint d --data a.npz", "cannot be used with"),
            ("reseflow bench runs/a --steps 1", "cannot be used with"),
            ("reseflow rollout --policy expert --task triangle --episodes 2 --seed 1 --steps 1", "--out"),
        ];
        for (line, part) in cases {
            let sentence = wrong(line);
            assert!(sentence.contains(part), "{line}: {sentence}");
            assert!(!sentence.contains('\n') && !sentence.contains("Usage"), "{sentence}");
        }
    }

    #[test]
    fn every_command_has_help_with_an_example() {
        for command in [
            "gen", "inspect", "train", "reflow", "predict", "eval", "rollout", "run", "equiv", "bench",
            "report",
        ] {
            match parse(["reseflow", command, "--help"].map(OsString::from)) {
                Parsed::Help(text) => assert!(text.contains(&format!("  reseflow {command} ")), "{text}"),
                _ => panic!("no help for {command}"),
            }
        }
    }
}
