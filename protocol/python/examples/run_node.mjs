// node.py on MicroPython's WebAssembly build: the line is stdin and stdout, the sensor says what it is told.
// usage: node run_node.mjs ECHO_US      ends when stdin ends

import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const here = new URL(".", import.meta.url);
const installed = createRequire(new URL("../../tests/micropython/package.json", here));
const { loadMicroPython } = await import(
  pathToFileURL(installed.resolve("@micropython/micropython-webassembly-pyscript"))
);

const python = await loadMicroPython({ heapsize: 1024 * 1024, stdout: (line) => console.error(line) });
python.FS.mkdir("/rover_protocol");
const library = new URL("../rover_protocol/", here);
for (const name of readdirSync(library).filter((name) => name.endsWith(".py"))) {
  python.FS.writeFile(`/rover_protocol/${name}`, readFileSync(new URL(name, library), "utf8"));
}
python.FS.writeFile("/node.py", readFileSync(new URL("node.py", here), "utf8"));

// What crosses between the two languages is text: bytes in hexadecimal.
python.runPython(`
import sys
sys.path.append("/")
from node import Node

time_us = 0
said = bytearray()

def write(buffer, length):
    said.extend(buffer[:length])

node = Node(write, lambda: time_us)

def step(now_us, heard, echo_us):
    global time_us, said
    time_us = now_us & 0xFFFFFFFF
    node.receive(bytes.fromhex(heard) if heard else b"")
    node.tick()
    if echo_us >= -1:
        node.ranged(echo_us, time_us)
    answer = said.hex() if said else ""
    said = bytearray()
    return answer
`);

const step = python.globals.get("step");
const echo = Number(process.argv[2] ?? 0);
const NO_PING = -2;
const PING_MS = 60;
let pinged = performance.now();

function serve(heard) {
  const now = performance.now();
  const due = now - pinged >= PING_MS;
  if (due) pinged = now;
  const answer = step(Math.floor(now * 1000), heard.toString("hex"), due ? echo : NO_PING);
  if (answer) process.stdout.write(Buffer.from(answer, "hex"));
}

process.stdin.on("data", serve);
process.stdin.on("end", () => process.exit(0));
setInterval(() => serve(Buffer.alloc(0)), 5);
