//! The parameters' values; what they are is described in the generated table.

use crate::parameter_table::Definition;
pub use crate::parameter_table::{Parameter, COUNT, DEFINITIONS};

/// Where in the table each identifier is, so that no search is needed.
const PLACES: [u8; 80] = {
    let mut places = [0; 80];
    let mut rest: &[Definition] = &DEFINITIONS;
    let mut place = 0;
    while let [definition, tail @ ..] = rest {
        let identifier = definition.parameter as usize;
        // Not indexed: a constant expression, checked by the compiler.
        #[allow(clippy::indexing_slicing)]
        {
            places[identifier] = place;
        }
        place += 1;
        rest = tail;
    }
    places
};

/// Why a parameter could not be read or set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterError {
    Unknown,
    OutOfRange,
}

/// The values in memory.
#[derive(Clone, Debug)]
pub struct Parameters {
    values: [i32; COUNT],
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            values: DEFINITIONS.map(|definition| definition.default),
        }
    }
}

impl Parameters {
    pub fn value(&self, parameter: Parameter) -> i64 {
        let place = PLACES.get(parameter as usize).copied().unwrap_or(0);
        self.values
            .get(usize::from(place))
            .copied()
            .map_or(0, i64::from)
    }

    /// Value by the identifier on the wire.
    pub fn get(&self, identifier: u16) -> Result<i32, ParameterError> {
        let (at, _) = find(identifier)?;
        self.values.get(at).copied().ok_or(ParameterError::Unknown)
    }

    pub fn set(&mut self, identifier: u16, value: i32) -> Result<(), ParameterError> {
        let (at, definition) = find(identifier)?;
        if !(definition.minimum..=definition.maximum).contains(&value) {
            return Err(ParameterError::OutOfRange);
        }
        let slot = self.values.get_mut(at).ok_or(ParameterError::Unknown)?;
        *slot = value;
        Ok(())
    }
}

fn find(identifier: u16) -> Result<(usize, &'static Definition), ParameterError> {
    DEFINITIONS
        .iter()
        .enumerate()
        .find(|(_, definition)| definition.parameter as u16 == identifier)
        .ok_or(ParameterError::Unknown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_rise_and_defaults_are_in_range() {
        for pair in DEFINITIONS.windows(2) {
            assert!((pair[0].parameter as u16) < pair[1].parameter as u16);
        }
        for d in DEFINITIONS {
            assert!(
                d.minimum <= d.default && d.default <= d.maximum,
                "{}",
                d.name
            );
        }
    }

    #[test]
    fn each_value_is_that_of_its_own_identifier() {
        let parameters = Parameters::default();
        for definition in DEFINITIONS {
            let value = parameters.value(definition.parameter);
            assert_eq!(value, i64::from(definition.default));
        }
    }

    #[test]
    fn a_value_out_of_range_or_unknown_changes_nothing() {
        let mut parameters = Parameters::default();
        assert_eq!(parameters.set(1, 49), Err(ParameterError::OutOfRange));
        assert_eq!(parameters.get(1), Ok(300));
        assert_eq!(parameters.set(1, 50), Ok(()));
        assert_eq!(parameters.get(1), Ok(50));
        assert_eq!(parameters.set(999, 1), Err(ParameterError::Unknown));
        assert_eq!(parameters.get(999), Err(ParameterError::Unknown));
    }
}
