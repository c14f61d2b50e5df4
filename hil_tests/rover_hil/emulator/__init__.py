"""The `emulator` rig: the ELF that is flashed, run by an emulated RP2040 that is wired pin by pin to the plant.

Peripherals are rp2040py's; what it gets wrong is corrected in one file each, with the section of the RP2040 datasheet:
`pl011.py` (4.2), `pwm.py` (4.5), `pio.py` (3), and in Rust (`rover_plant`) the processor with its interrupt
controller (2.4), the SIO's divider (2.3.1.5) and the timer (4.6).
"""

import signal

# Sent to the process it hangs the firmware's control loop, from the next millisecond on.
HANG_SIGNAL = signal.SIGUSR1
# The control loop's tick is kept from it, and comes again: what preempts the loop too long does that.
BLOCK_SIGNALS = (signal.SIGRTMIN + 1, signal.SIGRTMIN + 2)
# INT of the CAN controller is shorted to ground, and is free again.
GROUND_SIGNALS = (signal.SIGRTMIN + 3, signal.SIGRTMIN + 4)
