// A script in the official MicroPython interpreter, in Node; what it prints goes to standard output.
//
//     node emulation/micropython/script.mjs INTERPRETER FOLDER SCRIPT
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

const [interpreter, folder, script] = process.argv.slice(2);
const { loadMicroPython } = await import(pathToFileURL(path.join(interpreter, "micropython.mjs")).href);
const python = await loadMicroPython({ heapsize: 64 * 1024 * 1024, stdout: (line) => process.stdout.write(line + "\n") });
for (const name of fs.readdirSync(folder)) python.FS.writeFile("/" + name, fs.readFileSync(path.join(folder, name)));
python.runPython(`import sys\nsys.path.append("/")\nimport ${script}`);
