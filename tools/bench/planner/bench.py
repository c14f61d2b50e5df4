"""Runs the planner's tables one after the other."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from tools.bench.planner import floor, ompl_wheel, one_tree, peers, table4, tables

TABLES = ("paper", "trees", "floor", "maps", "fields", "replan")


def main(arguments: list[str]) -> int:
    """Prints the tables asked for as Markdown."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench planner", description=__doc__)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder that holds maps/")
    parser.add_argument("--only", choices=TABLES, action="append", help="this table alone; may be repeated")
    parser.add_argument("--first", type=int, default=0, help="first seed of the replan table")
    parser.add_argument("--sizes", type=float, nargs="+", default=[20.0, 40.0], help="sides of the fields, metres")
    parser.add_argument("--goals", type=int, nargs="+", default=[4, 10])
    parser.add_argument("--tasks", type=int, default=12, help="tasks on each ground of the floor table")
    parser.add_argument("--grounds", type=int, default=6, help="grounds of each generated family")
    parser.add_argument("--every", type=int, default=20, help="every so many scenarios of the maps")
    parser.add_argument("--map-budget-ms", type=float, default=50.0)
    parser.add_argument("--figure", type=Path, help="draw the paper's field as figure 11 does, into this .svg")
    options = parser.parse_args(arguments)
    wanted = options.only or list(TABLES)
    with peers.scratch() as folder:
        program, what = peers.build(Path(folder)) if {"paper", "floor", "fields"} & set(wanted) else (None, "")
        if what:
            print(f"Peers: {what}.", file=sys.stderr)
        if "paper" in wanted and not ompl_wheel.available():
            print("OMPL's wheel is not installed (pip install ompl) and left out.", file=sys.stderr)
        load = os.getloadavg()[0] / (os.cpu_count() or 1)
        if load > 0.7:
            print(f"The machine is busy (load {load:.1f} per core): even processor times are longer.", file=sys.stderr)
        if "paper" in wanted:
            print(
                f"Table 4 of the paper and ours, medians of {options.seeds} seeds:\n\n{table4.table(options.seeds)}\n"
            )
            found = tables.paper_table(program, options.seeds, options.figure)
            print(f"The paper's field, {options.seeds} seeds:\n\n{found}\n")
        if "trees" in wanted:
            print(f"One tree or a tree a goal, {options.seeds} seeds:\n\n{one_tree.table(options.seeds)}\n")
        if "floor" in wanted:
            folder_of_maps = None if options.data is None else Path(options.data) / "maps"
            found = floor.table(program, folder_of_maps, options.tasks, options.grounds)
            print(f"Without a budget, beside grid A* and string pulling:\n\n{found}\n")
        if "maps" in wanted and options.data is None:
            print("no maps: give --data DIR or ROVER_DATA", file=sys.stderr)
        elif "maps" in wanted:
            found = tables.map_table(Path(options.data) / "maps", options.map_budget_ms, options.every)
            print(f"MovingAI, radius 1/3 cell, {options.map_budget_ms:g} ms:\n\n{found}\n")
            found = tables.map_server_table(Path(options.data) / "maps", options.map_budget_ms, options.seeds)
            print(f"map_server, radius 0.2 m, {options.map_budget_ms:g} ms, {options.seeds} pairs:\n\n{found}\n")
        if "fields" in wanted:
            found = tables.field_table(program, options.seeds, options.sizes, options.goals)
            print(f"Fields with 40 % blocked, any order, {options.seeds} seeds:\n\n{found}\n")
        if "replan" in wanted:
            found = tables.replan_table(options.seeds, options.sizes, options.first)
            print(f"After 5 % of the cells changed, {options.seeds} seeds:\n\n{found}\n")
    return 0
