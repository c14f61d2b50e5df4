//! Links only if `rover_core` cannot panic.
//!
//! Everything that the board calls is called here, with values that the compiler knows nothing of. The panic handler
//! needs a symbol that does not exist: if one panic is left after optimisation, the linker reports that symbol and
//! the function that it was in.

#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;

use rover_core::storage::{Flash, FlashError, BLOCK};
use rover_core::{Core, Identity, InertialSample, Inputs, SonarEcho};

extern "C" {
    fn rover_core_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    // SAFETY: never linked, so never called.
    unsafe { rover_core_can_panic() }
}

/// Flash that may hold anything and fail at any time.
struct AnyFlash;

impl Flash for AnyFlash {
    fn erase(&mut self, page: usize) -> Result<(), FlashError> {
        black_box(page);
        black_box(Ok(()))
    }

    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
        black_box((page, block));
        black_box(Ok(()))
    }

    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
        black_box((page, block));
        black_box(Ok(()))
    }
}

#[no_mangle]
extern "C" fn _start() -> ! {
    let mut core = Core::new(black_box(Identity::default()));
    core.attach_storage(&mut AnyFlash);
    let crash = rover_core::crash::CrashRecord {
        cause: 0,
        task: 0,
        detail: 0,
        program_counter: 0,
        uptime_ms: 0,
        stack_bytes: 0,
        count: 0,
        events: Default::default(),
    };
    core.keep_crash(black_box(crash), &mut AnyFlash);
    let mut bytes = [0; 64];
    loop {
        let received = black_box(&bytes).get(..black_box(24)).unwrap_or_default();
        core.receive(received, black_box(0));
        core.receive_frame(black_box(0), received, black_box(0));
        if black_box(false) {
            core.note_receive_overflow();
            core.note_fault(black_box(0), black_box(1), black_box(0));
            core.note_bus_errors(black_box(1));
            core.log_line(black_box(""));
        }
        let outputs = core.tick(&black_box(Inputs {
            sonar: Some(SonarEcho {
                sensor: 0,
                echo_us: 0,
            }),
            inertial: Some(InertialSample::default()),
            ..Inputs::default()
        }));
        black_box(outputs);
        black_box(core.take_event());
        core.serve_storage(&mut AnyFlash);
        black_box(core.take_reboot());
        let frame = core.transmit_frame();
        black_box(frame.as_ref().map(|frame| frame.payload()));
        let sent = core.transmit(&mut bytes);
        black_box(sent);
        if cfg!(feature = "provoke") {
            black_box(bytes[black_box(sent)]);
        }
    }
}
