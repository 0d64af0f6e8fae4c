//! The parameters of a material of any model.

use crate::brdf::Brdf;
use crate::models::model::ChannelModel;
use crate::models::parameter::ParameterError;
use crate::models::registry::ModelName;

/// The parameters of a material: a model and its values for R, G and B. They are inside of the model's domain.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialParameters {
    model: ModelName,
    channels: [Vec<f64>; 3],
}

/// Errors of the parameters of a material.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("channel {channel}: {error}")]
pub struct ChannelError {
    /// 0, 1, 2 for R, G, B.
    pub channel: usize,
    /// The parameter, with its domain.
    pub error: ParameterError,
}

impl MaterialParameters {
    /// Values of R, G and B in the order of the model's [`crate::Model::parameters`].
    ///
    /// # Errors
    /// The first channel with a value outside of the model's domain.
    ///
    /// # Panics
    /// If the number of values is not that of the model's parameters.
    pub fn new(model: ModelName, channels: [Vec<f64>; 3]) -> Result<Self, ChannelError> {
        for (channel, values) in channels.iter().enumerate() {
            model.model().channel(values).map_err(|error| ChannelError { channel, error })?;
        }
        Ok(Self { model, channels })
    }

    /// The model.
    pub fn model(&self) -> ModelName {
        self.model
    }

    /// The values of channel R, G or B (0, 1, 2) in the order of the model's parameters.
    pub fn channel(&self, channel: usize) -> &[f64] {
        &self.channels[channel]
    }

    /// The value of the parameter of this name in channel R, G or B (0, 1, 2).
    pub fn get(&self, channel: usize, name: &str) -> Option<f64> {
        let place = self.model.model().parameters().iter().position(|parameter| parameter.name == name)?;
        Some(self.channels[channel][place])
    }

    /// The model of channel R, G or B (0, 1, 2).
    pub fn channel_model(&self, channel: usize) -> Box<dyn ChannelModel> {
        self.model.model().channel(&self.channels[channel]).expect("checked when it was made")
    }

    /// The material, ready to be evaluated and sampled.
    pub fn brdf(&self) -> Box<dyn Brdf> {
        let channels = self.channels.each_ref().map(Vec::as_slice);
        self.model.model().material(channels).expect("checked when it was made")
    }
}
