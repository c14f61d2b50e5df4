// Runs check.py on MicroPython with rover_protocol and the golden vectors in its file system.
// usage: node run.mjs; exit code 0 when every check passed

import { loadMicroPython } from "@micropython/micropython-webassembly-pyscript";
import { readFileSync, readdirSync } from "node:fs";

const here = new URL(".", import.meta.url);
const read = (path) => readFileSync(new URL(path, here), "utf8");

const python = await loadMicroPython({ heapsize: 2 * 1024 * 1024, stdout: (line) => console.log(line) });
python.FS.mkdir("/rover_protocol");
for (const name of readdirSync(new URL("../../python/rover_protocol", here))) {
  if (name.endsWith(".py")) {
    python.FS.writeFile(`/rover_protocol/${name}`, read(`../../python/rover_protocol/${name}`));
  }
}
for (const name of ["messages.json", "streams.json"]) {
  python.FS.writeFile(`/${name}`, read(`../../vectors/${name}`));
}
try {
  python.runPython(`import sys\nsys.path.append("/")\n${read("check.py")}`);
} catch (error) {
  console.error(String(error));
  process.exit(1);
}
