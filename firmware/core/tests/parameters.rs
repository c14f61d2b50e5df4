//! Parameters over the wire: saved on command, back after a restart, and never while the motors are on.

mod rig;

use rig::Rig;
use rover_core::storage::{Flash, FlashError, BLOCK, CRASH_PAGE};
use rover_core::{Core, Identity};
use rover_protocol::messages as m;
use rover_protocol::messages::{
    parameter_command_command as command, parameter_value_status as status,
};

#[derive(Default)]
struct Pages {
    blocks: [Option<[u8; BLOCK]>; CRASH_PAGE + 1],
    broken: bool,
}

impl Flash for Pages {
    fn erase(&mut self, page: usize) -> Result<(), FlashError> {
        self.blocks[page] = None;
        Ok(())
    }

    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
        if self.broken {
            return Err(FlashError);
        }
        self.blocks[page] = Some(*block);
        Ok(())
    }

    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
        *block = self.blocks[page].unwrap_or([0xff; BLOCK]);
        Ok(())
    }
}

/// A rig whose core has just started with this flash.
fn start(flash: &mut Pages) -> Rig {
    let mut rig = Rig::new();
    rig.core = Core::new(Identity::default());
    rig.core.attach_storage(flash);
    rig.run_ms(100);
    rig
}

fn order(rig: &mut Rig, flash: &mut Pages, command: u8) -> m::ParameterValue {
    rig.send(&m::ParameterCommand { command });
    rig.core.serve_storage(flash);
    rig.tick();
    let answer: m::ParameterValue = rig.last().unwrap();
    assert_eq!(
        (answer.identifier, answer.value),
        (u16::MAX, i32::from(command))
    );
    answer
}

fn dead_man(rig: &mut Rig) -> i32 {
    rig.send(&m::ParameterGet { identifier: 1 });
    rig.tick();
    rig.last::<m::ParameterValue>().unwrap().value
}

fn set_dead_man(rig: &mut Rig, value: i32) {
    let identifier = 1;
    rig.send(&m::ParameterSet { identifier, value });
    rig.tick();
}

#[test]
fn what_is_saved_is_there_after_a_restart_and_what_is_not_is_gone() {
    let mut flash = Pages::default();
    let mut rig = start(&mut flash);
    set_dead_man(&mut rig, 400);
    assert_eq!(
        order(&mut rig, &mut flash, command::SAVE).status,
        status::OK
    );
    set_dead_man(&mut rig, 500);
    let mut rig = start(&mut flash);
    assert_eq!(dead_man(&mut rig), 400);
    assert_eq!(
        order(&mut rig, &mut flash, command::DEFAULTS).status,
        status::OK
    );
    assert_eq!(dead_man(&mut rig), 300);
    assert_eq!(
        order(&mut rig, &mut flash, command::LOAD).status,
        status::OK
    );
    assert_eq!(dead_man(&mut rig), 400);
}

#[test]
fn nothing_is_written_while_the_motors_are_on() {
    let mut flash = Pages::default();
    let mut rig = start(&mut flash);
    rig.make_armed();
    let answer = order(&mut rig, &mut flash, command::SAVE);
    assert_eq!(answer.status, status::REFUSED_WHILE_ARMED);
    assert!(flash.blocks.iter().all(Option::is_none));
}

#[test]
fn a_flash_that_fails_or_holds_nothing_is_reported_and_changes_nothing() {
    let mut flash = Pages::default();
    let mut rig = start(&mut flash);
    let answer = order(&mut rig, &mut flash, command::LOAD);
    assert_eq!(answer.status, status::STORAGE_ERROR);
    flash.broken = true;
    set_dead_man(&mut rig, 400);
    let answer = order(&mut rig, &mut flash, command::SAVE);
    assert_eq!(answer.status, status::STORAGE_ERROR);
    assert_eq!(dead_man(&mut rig), 400);
}

#[test]
fn a_board_without_storage_says_so() {
    let mut rig = Rig::new();
    rig.run_ms(100);
    rig.send(&m::ParameterCommand {
        command: command::SAVE,
    });
    rig.tick();
    let answer: m::ParameterValue = rig.last().unwrap();
    assert_eq!(answer.status, status::STORAGE_ERROR);
}
