//! Rollouts as MCAP logs with Foxglove's schemas: they open as they are in Foxglove and in Rerun.
//!
//! | topic | schema | when |
//! |---|---|---|
//! | `/observation/points` | `foxglove.PointCloud` | every control tick, and before the first |
//! | `/tf` | `foxglove.FrameTransforms` | likewise: `world` → `gripper` (reached) and → `gripper_command` |
//! | `/scene` | `foxglove.SceneUpdate` | likewise: every body, so that a viewer may jump to any time |
//! | `/gripper/opening` | JSON | likewise: `commanded` and `reached`, 0 closed to 1 open |
//! | `/contacts` | JSON | every control tick: what touches what, where and how hard |
//! | `/contacts/markers` | `foxglove.SceneUpdate` | likewise: a ball at each contact |
//! | `/measure` | JSON | every control tick: the task's success measure |
//! | `/plan/poses` | `foxglove.PosesInFrame` | whenever the policy plans |
//! | `/plan/uncertainty` | JSON | likewise, where the policy states one |
//! | `/executed/poses` | `foxglove.PosesInFrame` | every action step, and at the end: the reached poses so far |
//! | `/outcome` | JSON | at the end of each episode |
//!
//! Time starts at 0. Episodes follow one another with a second between them, so that one file can hold several.

mod file;
mod messages;
mod summary;
mod training;

use std::path::Path;

use foxglove::messages as fox;
use reseflow_lie::SE3;
use serde::Serialize;

use crate::{Contact, DataError, EpisodeObserver, Observation, Outcome, Plan, Scene, Tick};
use file::{LogFile, Topic};
pub use summary::{McapSummary, TopicSummary};
pub use training::{TrainingNotes, write_training_log};

/// Between the last tick of an episode and the start of the next one.
const GAP_NANOS: i64 = 1_000_000_000;

/// A log under way. It becomes a file at [`McapLog::finish`]; dropped before that, it leaves nothing.
pub struct McapLog {
    file: LogFile,
    topics: Topics,
    /// The current time on the log's clock.
    now_nanos: i64,
    /// The log time at which the current episode began.
    origin_nanos: i64,
    /// Episodes begun.
    episodes: usize,
    /// Reached poses of the current episode, and how many of them are logged.
    executed: Vec<SE3>,
    executed_logged: usize,
    /// The first thing that went wrong; nothing is logged after it.
    fault: Option<DataError>,
}

struct Topics {
    points: Topic,
    transforms: Topic,
    scene: Topic,
    opening: Topic,
    contacts: Topic,
    contact_markers: Topic,
    measure: Topic,
    plan: Topic,
    uncertainty: Topic,
    executed: Topic,
    outcome: Topic,
}

#[derive(Serialize)]
struct OpeningMessage {
    commanded: f64,
    reached: f64,
}

#[derive(Serialize)]
struct ContactsMessage<'a> {
    total_force_n: f64,
    contacts: &'a [Contact],
}

#[derive(Serialize)]
struct MeasureMessage {
    measure: f64,
}

#[derive(Serialize)]
struct UncertaintyMessage<'a> {
    per_action: &'a [f64],
}

#[derive(Serialize)]
struct OutcomeMessage<'a> {
    episode: usize,
    #[serde(flatten)]
    outcome: &'a Outcome,
}

impl Topics {
    fn add(file: &mut LogFile) -> Result<Self, DataError> {
        Ok(Self {
            points: file.add_topic::<fox::PointCloud>("/observation/points")?,
            transforms: file.add_topic::<fox::FrameTransforms>("/tf")?,
            scene: file.add_topic::<fox::SceneUpdate>("/scene")?,
            opening: file.add_json_topic(
                "/gripper/opening",
                "reseflow.Opening",
                &["commanded", "reached"],
            )?,
            contacts: file.add_json_topic("/contacts", "reseflow.Contacts", &["total_force_n"])?,
            contact_markers: file.add_topic::<fox::SceneUpdate>("/contacts/markers")?,
            measure: file.add_json_topic("/measure", "reseflow.Measure", &["measure"])?,
            plan: file.add_topic::<fox::PosesInFrame>("/plan/poses")?,
            uncertainty: file.add_json_topic("/plan/uncertainty", "reseflow.Uncertainty", &[])?,
            executed: file.add_topic::<fox::PosesInFrame>("/executed/poses")?,
            outcome: file.add_json_topic("/outcome", "reseflow.Outcome", &["episode", "measure"])?,
        })
    }
}

impl McapLog {
    /// Starts a log that is to become `path`.
    ///
    /// # Errors
    /// When the folder is missing or cannot be written to.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let mut file = LogFile::create(path.as_ref())?;
        let topics = Topics::add(&mut file)?;
        Ok(Self {
            file,
            topics,
            now_nanos: 0,
            origin_nanos: 0,
            episodes: 0,
            executed: Vec::new(),
            executed_logged: 0,
            fault: None,
        })
    }

    /// Completes the file and puts it in place, replacing what was there.
    ///
    /// # Errors
    /// What went wrong first while logging, or now; what was there before then stays as it was.
    pub fn finish(self) -> Result<(), DataError> {
        match self.fault {
            Some(fault) => Err(fault),
            None => self.file.finish(),
        }
    }

    /// Runs `log` unless something went wrong before, and remembers what goes wrong in it.
    fn try_log(&mut self, log: impl FnOnce(&mut Self) -> Result<(), DataError>) {
        if self.fault.is_none() {
            self.fault = log(self).err();
        }
    }

    fn begin_episode(&mut self, first: &Observation, scene: &dyn Scene) -> Result<(), DataError> {
        if self.episodes > 0 {
            self.now_nanos += GAP_NANOS;
        }
        self.episodes += 1;
        self.origin_nanos = self.now_nanos;
        self.executed.clear();
        self.executed_logged = 0;
        self.log_state(first, &first.world_from_gripper, first.gripper_opening, scene)
    }

    /// Logs what is true at this time: the frame, the reached and commanded gripper, the bodies.
    fn log_state(
        &mut self,
        observation: &Observation,
        world_from_command: &SE3,
        commanded_opening: f64,
        scene: &dyn Scene,
    ) -> Result<(), DataError> {
        let (now, topics, file) = (self.now_nanos, &mut self.topics, &mut self.file);
        self.executed.push(observation.world_from_gripper);
        file.log(&mut topics.points, now, &messages::point_cloud(now, &observation.cloud))?;
        let transforms = vec![
            messages::transform(now, "gripper", &observation.world_from_gripper),
            messages::transform(now, "gripper_command", world_from_command),
        ];
        file.log(&mut topics.transforms, now, &fox::FrameTransforms { transforms })?;
        file.log(&mut topics.scene, now, &messages::bodies(now, &scene.bodies()))?;
        let opening = OpeningMessage { commanded: commanded_opening, reached: observation.gripper_opening };
        file.log_json(&mut topics.opening, now, &opening)
    }

    fn log_tick(&mut self, tick: &Tick, scene: &mut dyn Scene) -> Result<(), DataError> {
        self.now_nanos = self.origin_nanos + tick.time_nanos;
        let observation = Observation {
            world_from_gripper: tick.world_from_gripper,
            gripper_opening: tick.gripper_opening,
            ..scene.observe()
        };
        self.log_state(&observation, &tick.command.world_from_gripper, tick.command.opening, scene)?;
        let (now, topics, file) = (self.now_nanos, &mut self.topics, &mut self.file);
        let contacts = ContactsMessage {
            total_force_n: tick.contacts.iter().map(|contact| contact.force_n).sum(),
            contacts: &tick.contacts,
        };
        file.log_json(&mut topics.contacts, now, &contacts)?;
        file.log(&mut topics.contact_markers, now, &messages::contacts(now, &tick.contacts))?;
        file.log_json(&mut topics.measure, now, &MeasureMessage { measure: tick.measure })
    }

    /// Logs the path travelled so far, if it grew.
    fn log_executed(&mut self) -> Result<(), DataError> {
        if self.executed.len() > self.executed_logged {
            self.executed_logged = self.executed.len();
            let poses = messages::poses(self.now_nanos, self.executed.iter());
            self.file.log(&mut self.topics.executed, self.now_nanos, &poses)?;
        }
        Ok(())
    }

    fn log_plan(&mut self, plan: &Plan) -> Result<(), DataError> {
        let (now, topics, file) = (self.now_nanos, &mut self.topics, &mut self.file);
        let poses = messages::poses(now, plan.actions.iter().map(|action| &action.world_from_gripper));
        file.log(&mut topics.plan, now, &poses)?;
        match &plan.uncertainty {
            Some(per_action) => {
                file.log_json(&mut topics.uncertainty, now, &UncertaintyMessage { per_action })
            }
            None => Ok(()),
        }
    }
}

impl EpisodeObserver for McapLog {
    fn on_observation(&mut self, step: usize, observation: &Observation, scene: &dyn Scene) {
        self.try_log(|log| {
            if step == 0 {
                log.begin_episode(observation, scene)?;
            }
            log.log_executed()
        });
    }

    fn on_plan(&mut self, _step: usize, plan: &Plan) {
        self.try_log(|log| log.log_plan(plan));
    }

    fn on_tick(&mut self, tick: &Tick, scene: &mut dyn Scene) {
        self.try_log(|log| log.log_tick(tick, scene));
    }

    fn on_outcome(&mut self, outcome: &Outcome) {
        self.try_log(|log| {
            log.log_executed()?;
            let message = OutcomeMessage { episode: log.episodes.saturating_sub(1), outcome };
            log.file.log_json(&mut log.topics.outcome, log.now_nanos, &message)
        });
    }
}
