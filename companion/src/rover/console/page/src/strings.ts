// Every word of the page, in one place: a translation is a second catalogue of these keys.
const en = {
  title: "Rover console",
  skip_link: "Skip to content",
  plan: "Plan", drive: "Drive", judge: "Judge", review: "Review",
  pages: "Pages",
  pair_title: "Pair this browser",
  pair_help: "The code stands on the first line that rover console printed.",
  code: "Pairing code", your_name: "Your name", pair: "Pair", leave: "Leave",
  operator_is: "Operator: {name}", operator_you: "You are the operator", operator_none: "Nobody operates",
  take_seat: "Operate", ask_seat: "Ask to operate", asked_seat: "Asked: the operator sees it",
  free_seat: "Leave the seat", hand_to: "Hand over to {name}", asks: "{name} asks to operate",
  looks_on: "You look on",
  emergency: "Emergency stop", emergency_sent: "Emergency stop …",
  emergency_done: "Emergency stop sent to the firmware, {ms} ms after the click", emergency_failed: "Not confirmed: {why}. Use the button on the rover.",
  emergency_none: "No mission is on its way",
  connection_lost: "No connection to the console. The mission goes on; the button on the rover works.",
  connection_back: "Connected",
  // plan
  mission: "Mission", mission_load: "Mission to load", mission_drive: "Mission to drive", load: "Load", new_mission: "New", save: "Save", saved: "Saved {name}",
  download: "Download TOML", import_file: "Import TOML, GeoJSON or KML", imported: "Imported {count} shapes",
  import_none: "No shapes in {name}", import_bad: "{name} cannot be read: {why}",
  file_name: "File name", max_duration: "Time limit, s", required_coverage: "Required coverage, %",
  return_home: "Come home at the end",
  site: "Site", weather: "Weather", site_name: "Place", organisation: "Organisation", operator: "Operator",
  latitude: "Origin, latitude", longitude: "Origin, longitude", bearing: "Bearing of +y, °",
  launch: "Launch", launch_x: "x, m", launch_y: "y, m", launch_heading: "Heading, °",
  lanes: "Lanes", lane_width: "Width, m", lane_heading: "Heading, °", lane_overlap: "Overlap, m",
  draw: "Draw", draw_area: "Area", draw_exclude: "Exclusion", draw_obstacle: "Obstacle", draw_goal: "Goal",
  draw_launch: "Launch", draw_marker: "Marker", draw_move: "Move points", undo: "Undo", remove_last: "Remove last",
  draw_help: "Click on the map; a double click ends a shape. Without a mouse: edit the mission file below.",
  corners: "Corners of the area, x, y a line", apply: "Apply",
  toml: "Mission file (TOML)", problem_none: "rover run accepts this mission",
  estimate: "Expected", est_area: "Area", est_duration: "Duration", est_energy: "Energy", est_coverage: "Coverage",
  est_unknown: "unknown: no earlier run here", est_from: "from {runs} earlier runs in this folder",
  checks: "Check list", run_checks: "Check now", check_mission: "Mission file", check_when: "Hours to survey",
  checking: "Checking …", soil: "Soil", date: "Date",
  when_line: "{depth} cm deep: best at {hour}, seen {hours}", when_never: "{depth} cm deep: not seen",
  // drive
  start: "Start", start_title: "Start a mission", rig: "Rig", seed: "Seed", port: "Port", camera_source: "Camera",
  resume: "Go on from", resume_none: "begin anew", starting: "Starting …",
  run: "Run", choose_run: "Run to show", none_running: "No mission is on its way",
  pause: "Pause", go: "Go on", home: "Come home", stop: "Stop", skip: "Skip", skip_goal: "Goal to skip",
  commands: "Commands", told: "{word}: {says}",
  state: "State", state_name: "State", firmware: "Firmware", cause: "Last stop", time: "Time", surveyed: "Surveyed",
  left: "Time left", battery: "Battery", battery_left: "Battery left", link: "Link", position: "Position",
  sigma: "σ in map", relative_sigma: "σ among things", goals: "Goals", indications: "Indications", waits: "Waits for",
  link_value: "{lost} lost, {trip} ms", lost_run: "The mission no longer answers",
  events: "Events", thermal: "Thermal picture", thermal_none: "No picture yet",
  thermal_alt: "Thermal picture at {t} s with {n} candidates", layers: "Layers", map: "Map of the field",
  layer_temperature: "Temperature", layer_seen: "Seen", layer_obstacles: "Obstacles", layer_zones: "Keep-out zones",
  layer_track: "Way driven", layer_plan: "Plan", layer_sigma: "σ", layer_goals: "Goals", layer_plan_file: "Area",
  layer_other: "Other survey", legend_seen: "Seen is not the same as free of mines.",
  signals: "Signals", said: "What the mission's program said", ending: "Ending: {reason}", ended: "Ended: {status}, {reason}", report: "Report",
  // judge
  indication: "Indication {id}", judge_none: "No indications in this run", judge_choose: "Choose an indication", probability: "p {p}",
  at: "at {x}, {y} m ± {s} m", confirm: "Confirm: looks like a mine", reject: "Reject: looks like something else",
  mark: "Mark by hand", note: "Note", mark_note: "Note on the mark", marks: "Marks by hand", journal: "Journal of this run",
  judge_help: "Judgements are kept beside the run. A rejected indication stays in the record and stays keep-out.",
  confirmed: "confirmed", rejected: "rejected, stays keep-out", marked: "marked", unjudged: "not judged",
  judged_by: "{verdict} by {author}, {utc}", pictures: "Pictures over time", pictures_none: "No picture shows it",
  picture_alt: "Thermal picture at {t} s",
  // review
  runs: "Runs", filter: "Filter by place or date", when: "When", what: "What", how: "How it ended",
  replay: "Replay", slider: "Time in the mission", play: "Play", halt: "Halt", export: "Export", compare: "Compare with",
  compare_none: "nothing", compare_line: "{both} in both, {only_a} only in {a}, {only_b} only in {b} (within {m} m)",
  go_on: "Go on from here", interrupted: "interrupted", running: "on its way", over: "over", loading: "Loading …",
  runs_none: "No runs in this folder yet", replay_none: "This run has no log",
  error: "{why}",
};

export type Key = keyof typeof en;

export function t(key: Key, values: Record<string, string | number> = {}): string {
  return en[key].replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ""));
}

/** A word of the server's (a layer, a verdict, a state) in the catalogue, or as it came. */
export function word(key: string): string {
  return key in en ? en[key as Key] : key;
}
