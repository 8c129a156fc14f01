// A board with MicroPython: the official interpreter in Node, its line and its pins on two sockets of the bench.
//
//     node emulation/micropython/board.mjs INTERPRETER FOLDER HOST_PORT WIRE_PORT
//
// FOLDER is what a person copies to the board; machine.py and bench_time.py next to this file stand in for what is a chip's.
import fs from "node:fs";
import net from "node:net";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [interpreter, folder, hostPort, wirePort] = process.argv.slice(2);
const circuit = fs.readFileSync(path.join(folder, "circuit.json"), "utf8");
const here = path.dirname(fileURLToPath(import.meta.url));
const { loadMicroPython } = await import(pathToFileURL(path.join(interpreter, "micropython.mjs")).href);

function socket(port) {
  const connection = net.connect(Number(port), "127.0.0.1");
  let waiting = [];
  connection.setNoDelay(true);
  connection.on("data", (data) => waiting.push(...data));
  for (const end of ["error", "close"]) connection.on(end, () => process.exit(0));
  return {
    take: () => { const found = waiting; waiting = []; return found.join(" "); },
    send: (text) => { connection.write(Buffer.from(text, "hex")); },
  };
}

const host = socket(hostPort), pins = socket(wirePort);
const STAND_INS = ["start.py", "machine.py", "bench_time.py", "bench_line.py"];
// What survives a reset of the chip, which is a new interpreter here.
const kept = { cause: 1 };

for (;;) {
  const python = await loadMicroPython({ heapsize: 4 * 1024 * 1024, stdout: (line) => process.stderr.write(line + "\n") });
  const files = [...fs.readdirSync(folder).map((name) => path.join(folder, name)), ...STAND_INS.map((name) => path.join(here, name))];
  for (const file of files.filter((name) => name.endsWith(".py"))) {
    python.FS.writeFile("/" + path.basename(file), fs.readFileSync(file));
  }
  let reset;
  const ended = new Promise((resolve) => { reset = resolve; });
  python.registerJsModule("bench", {
    circuit, cause: () => kept.cause,
    host_take: host.take, host_send: host.send, pins_take: pins.take, pins_send: pins.send,
    halt: () => process.exit(0),
    reset: (cause) => { kept.cause = cause; reset(); },
  });
  try {
    python.runPythonAsync("import sys\nsys.path.append('/')\nimport start");
  } catch (problem) {
    process.stderr.write(String(problem) + "\n");
  }
  await ended;
}
