"""`rover hil`: fault scenarios on a rig, a rig by itself, and the worlds that it stands in."""

from __future__ import annotations

import typer
from rover.cli.commands import CONTEXT

from rover_hil.commands import scenarios, serve, world

HELP = """Fault scenarios: put a fault in while the real firmware drives, and see what comes of it. Or a rig by itself.

\b
Examples:
  rover hil list                                   those that ship
  rover hil run serial-cut sonar-near              two of them
  rover hil run my-faults/ --junit out.xml         a folder of your own, for a CI server
  rover hil serve demo --free-run                  a rig in real time, for any client
  rover hil world --example                        a file of all that can make the field unfriendly
"""

app = typer.Typer(help=HELP, rich_markup_mode=None, add_completion=False, context_settings=dict(CONTEXT))
app.command("run", help=scenarios.RUN_HELP, short_help="Run scenarios.")(scenarios.run)
app.command("list", help=scenarios.LIST_HELP, short_help="List scenarios and faults.")(scenarios.list_scenarios)
app.command("serve", help=serve.HELP, short_help="Run a rig by itself, for any client.")(serve.command)
app.command("world", help=world.HELP, short_help="The file of an unfriendly world.")(world.command)
