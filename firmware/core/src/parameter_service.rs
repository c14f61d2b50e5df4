//! Parameters over the link, and where they are kept.

use rover_protocol::messages as m;
use rover_protocol::messages::{
    parameter_command_command as parameter_command, parameter_value_status as parameter_status,
};

use crate::controller::Core;
use crate::crash;
use crate::parameters::{ParameterError, Parameters};
use crate::settings::Settings;
use crate::storage::{self, Flash, StorageOrder};

/// Identifier in the answer to a ParameterCommand; the value is the command.
const ALL_PARAMETERS: u16 = u16::MAX;

impl Core {
    /// Take the parameters that were saved, and from now on save them there. Once, before the first tick.
    pub fn attach_storage(&mut self, flash: &mut impl Flash) {
        self.has_storage = true;
        self.crash = crash::load(flash);
        if let Some(parameters) = storage::load(flash) {
            self.parameters = parameters;
            self.parameters_changed();
        }
    }

    /// Carry out a save or load that was asked for and allowed, if any, and answer it. The motors are off then, so
    /// the flash may keep the processor for as long as it takes.
    pub fn serve_storage(&mut self, flash: &mut impl Flash) {
        let Some(order) = self.storage_order.take() else {
            return;
        };
        // Armed since then, in the very same tick.
        let done = !self.supervisor.is_powered() && order.carry_out(&mut self.parameters, flash);
        self.parameters_changed();
        self.answer_storage(order, done);
    }

    /// To be called after each change of a parameter.
    pub(crate) fn parameters_changed(&mut self) {
        self.settings = Settings::new(&self.parameters);
    }

    /// Whether [`Core::serve_storage`] has something to do.
    pub fn wants_storage(&self) -> bool {
        self.storage_order.is_some()
    }

    pub(crate) fn parameter_get(&mut self, identifier: u16) {
        let result = self.parameters.get(identifier);
        self.answer_parameter(
            identifier,
            result.err().map_or(parameter_status::OK, status),
        );
    }

    pub(crate) fn parameter_set(&mut self, set: &m::ParameterSet) {
        let status = if self.supervisor.is_powered() {
            parameter_status::REFUSED_WHILE_ARMED
        } else {
            let result = self.parameters.set(set.identifier, set.value);
            self.parameters_changed();
            result.err().map_or(parameter_status::OK, status)
        };
        self.answer_parameter(set.identifier, status);
    }

    /// Answers with the value that holds now, 0 for a parameter that does not exist.
    fn answer_parameter(&mut self, identifier: u16, status: u8) {
        self.link.send_urgent(&m::ParameterValue {
            identifier,
            value: self.parameters.get(identifier).unwrap_or(0),
            status,
        });
    }

    /// Save and load wait for the board; everything else is answered here.
    pub(crate) fn parameter_command(&mut self, command: u8) {
        let status = match command {
            _ if self.supervisor.is_powered() => parameter_status::REFUSED_WHILE_ARMED,
            parameter_command::DEFAULTS => {
                self.parameters = Parameters::default();
                self.parameters_changed();
                parameter_status::OK
            }
            parameter_command::SAVE | parameter_command::LOAD if self.has_storage => {
                self.storage_order = Some(match command {
                    parameter_command::SAVE => StorageOrder::Save,
                    _ => StorageOrder::Load,
                });
                return;
            }
            parameter_command::SAVE | parameter_command::LOAD => parameter_status::STORAGE_ERROR,
            _ => parameter_status::UNKNOWN_PARAMETER,
        };
        self.answer_parameter_command(command, status);
    }

    pub(crate) fn answer_storage(&mut self, order: StorageOrder, done: bool) {
        let command = match order {
            // Told by what there is then.
            StorageOrder::ClearCrash => return,
            StorageOrder::Save => parameter_command::SAVE,
            StorageOrder::Load => parameter_command::LOAD,
        };
        let status = match done {
            true => parameter_status::OK,
            false => parameter_status::STORAGE_ERROR,
        };
        self.answer_parameter_command(command, status);
    }

    fn answer_parameter_command(&mut self, command: u8, status: u8) {
        self.link.send_urgent(&m::ParameterValue {
            identifier: ALL_PARAMETERS,
            value: i32::from(command),
            status,
        });
    }
}

fn status(error: ParameterError) -> u8 {
    match error {
        ParameterError::Unknown => parameter_status::UNKNOWN_PARAMETER,
        ParameterError::OutOfRange => parameter_status::OUT_OF_RANGE,
    }
}
