//! A training's state: everything that its next update depends on, and its file.
//!
//! The file is one: eight bytes of magic, the blake3 hash of all that follows, the length of a JSON header, the header, and then
//! the sections that it lists. Batches and noise are functions of (seed, update, shard), so no random generator is in it.

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::optim::ModuleOptimizer;
use burn::tensor::{Bytes, Device, Tensor, TensorData};
use serde::{Deserialize, Serialize};

use crate::ema::WeightAverage;
use crate::fingerprint::Fingerprint;
use crate::{TrainConfig, ValidationMetrics};

const MAGIC: &[u8; 8] = b"rsfstat1";
/// Magic, hash and the header's length.
const PREAMBLE: usize = 8 + 32 + 8;

/// Where a training stands after an update.
pub(crate) struct TrainState<N> {
    /// Updates made.
    pub(crate) update: usize,
    /// The weights that are optimised.
    pub(crate) net: N,
    /// The optimiser's moments and step counters.
    pub(crate) optimizer: ModuleOptimizer,
    /// The averaged weights.
    pub(crate) average: WeightAverage,
    /// The last validation.
    pub(crate) validation: Option<ValidationMetrics>,
    /// The best validation.
    pub(crate) best: Option<ValidationMetrics>,
    /// The averaged weights of the best validation.
    pub(crate) best_average: Option<WeightAverage>,
    /// Validations since the best one.
    pub(crate) stale: usize,
    /// The lines of the metrics file so far.
    pub(crate) metrics: Vec<u8>,
}

/// What a file says besides numbers; floats are kept as their bits, because JSON does not promise them to the last one.
#[derive(Serialize, Deserialize)]
struct Header {
    fingerprint: Fingerprint,
    update: usize,
    stale: usize,
    validation: Option<ValidationBits>,
    best: Option<ValidationBits>,
    parameters: Vec<u64>,
    metrics: usize,
    weights: usize,
    average: usize,
    best_average: Option<usize>,
    optimizer: usize,
}

type ValidationBits = (usize, [u64; 3]);

impl<N: Module> TrainState<N> {
    /// The state before the first update.
    pub(crate) fn new(net: N, train: &TrainConfig) -> Self {
        Self {
            update: 0,
            net,
            optimizer: train.optimizer.init(train.weight_decay),
            average: WeightAverage::new(train.ema_decay),
            validation: None,
            best: None,
            best_average: None,
            stale: 0,
            metrics: Vec::new(),
        }
    }

    /// The bytes of the state's file.
    ///
    /// # Errors
    /// What cannot be written down.
    pub(crate) fn to_bytes(&self, fingerprint: &Fingerprint) -> Result<Vec<u8>, String> {
        let mut taken = Take::default();
        self.net.visit(&mut taken);
        let optimizer = self.optimizer.into_bytes().map_err(|fault| fault.to_string())?;
        let average = self.average.flat(&self.net);
        let best_average = self.best_average.as_ref().map(|best| best.flat(&self.net));
        let header = Header {
            fingerprint: fingerprint.clone(),
            update: self.update,
            stale: self.stale,
            validation: self.validation.as_ref().map(bits),
            best: self.best.as_ref().map(bits),
            parameters: taken.ids,
            metrics: self.metrics.len(),
            weights: taken.values.len(),
            average: average.len(),
            best_average: best_average.as_ref().map(Vec::len),
            optimizer: optimizer.len(),
        };
        let header = serde_json::to_vec(&header).map_err(|fault| fault.to_string())?;
        let mut rest = (header.len() as u64).to_le_bytes().to_vec();
        rest.extend(header);
        rest.extend(&self.metrics);
        for values in [taken.values, average, best_average.unwrap_or_default()] {
            rest.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        rest.extend_from_slice(&optimizer);
        Ok([MAGIC.as_slice(), blake3::hash(&rest).as_bytes(), &rest].concat())
    }

    /// Reads a state's file back into a training of `fingerprint`, whose network is like `fresh`.
    ///
    /// # Errors
    /// A sentence's end that says why the file cannot be used: it is not whole, or of another training.
    pub(crate) fn from_bytes(
        bytes: &[u8],
        fingerprint: &Fingerprint,
        fresh: N,
        train: &TrainConfig,
        device: &Device,
    ) -> Result<Self, String> {
        let cut = || "is cut off or damaged".to_owned();
        if bytes.len() < PREAMBLE || &bytes[..8] != MAGIC {
            return Err("is cut off, or no training's state".to_owned());
        }
        if blake3::hash(&bytes[40..]).as_bytes() != &bytes[8..40] {
            return Err(cut());
        }
        let mut rest = Sections(&bytes[40..]);
        let length: [u8; 8] = rest.take(8).and_then(|length| length.try_into().ok()).ok_or_else(cut)?;
        let header =
            rest.take(usize::try_from(u64::from_le_bytes(length)).map_err(|_| cut())?).ok_or_else(cut)?;
        let header: Header =
            serde_json::from_slice(header).map_err(|_| "is of another version".to_owned())?;
        if let Some(difference) = header.fingerprint.difference(fingerprint) {
            return Err(format!("was left by a training {difference}"));
        }
        let metrics = rest.take(header.metrics).ok_or_else(cut)?.to_vec();
        let weights = rest.floats(header.weights).ok_or_else(cut)?;
        let average = rest.floats(header.average).ok_or_else(cut)?;
        let best_average = match header.best_average {
            Some(count) => Some(rest.floats(count).ok_or_else(cut)?),
            None => None,
        };
        let optimizer = rest.take(header.optimizer).ok_or_else(cut)?.to_vec();
        let mut put = Put { ids: &header.parameters, values: &weights, device, fits: true };
        let net = fresh.map(&mut put);
        if !(put.fits && put.ids.is_empty() && put.values.is_empty()) {
            return Err("holds other weights than those of the network".to_owned());
        }
        let restore =
            |values: &[f64]| WeightAverage::from_flat(train.ema_decay, &net, values).ok_or_else(cut);
        let new = Self::new(net.clone(), train);
        Ok(Self {
            update: header.update,
            optimizer: (new.optimizer.from_bytes(Bytes::from_bytes_vec(optimizer))).map_err(|_| cut())?,
            average: restore(&average)?,
            validation: header.validation.map(from_bits),
            best: header.best.map(from_bits),
            best_average: best_average.map(|values| restore(&values)).transpose()?,
            stale: header.stale,
            metrics,
            net,
        })
    }
}

fn bits(metrics: &ValidationMetrics) -> ValidationBits {
    (metrics.update, [metrics.d_geo, metrics.rotation_rad, metrics.translation_m].map(f64::to_bits))
}

fn from_bits((update, values): ValidationBits) -> ValidationMetrics {
    let [d_geo, rotation_rad, translation_m] = values.map(f64::from_bits);
    ValidationMetrics { update, d_geo, rotation_rad, translation_m }
}

/// What is left to read.
struct Sections<'a>(&'a [u8]);

impl<'a> Sections<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn floats(&mut self, count: usize) -> Option<Vec<f64>> {
        let bytes = self.take(count.checked_mul(8)?)?;
        Some(bytes.as_chunks().0.iter().map(|value| f64::from_le_bytes(*value)).collect())
    }
}

/// The names and values of all parameters, in the order of a visit.
#[derive(Default)]
struct Take {
    ids: Vec<u64>,
    values: Vec<f64>,
}

impl ModuleVisitor for Take {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.ids.push(param.id.val());
        self.values.extend(param.val().try_to_vec_as::<f64>().unwrap_or_default());
    }
}

/// Puts names and values back. The names matter: the optimiser finds its moments by them.
struct Put<'a> {
    ids: &'a [u64],
    values: &'a [f64],
    device: &'a Device,
    fits: bool,
}

impl ModuleMapper for Put<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let (_, tensor, mapper) = param.clone().consume();
        let dims = tensor.dims();
        let taken = (self.ids.split_first()).zip(self.values.split_at_checked(dims.iter().product()));
        let Some(((id, ids), (mine, values))) = taken else {
            self.fits = false;
            return param;
        };
        (self.ids, self.values) = (ids, values);
        let restored = Tensor::from_data(TensorData::new(mine.to_vec(), dims), self.device);
        let restored = if tensor.is_require_grad() { restored.require_grad() } else { restored };
        Param::from_mapped_value(ParamId::from(*id), restored, mapper)
    }
}
