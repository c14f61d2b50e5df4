"""The wire to the firmware: transports, clock estimate, segment streaming and the session that ties them."""
