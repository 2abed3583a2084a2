// Assembles the page in one file: node assemble.mjs TEMPLATE STYLE CODE PACKAGES OUT.html
// PACKAGES is the folder of the npm packages; their licences, and those of HDF5 in h5wasm and fflate in three, are included.
import fs from "node:fs";
import path from "node:path";

const [template, style, code, packages, out] = process.argv.slice(2);
const read = (file) => fs.readFileSync(file, "utf8");
const ownFolder = path.dirname(process.argv[1]);
const licences = [["three.js", packages, "three/LICENSE"], ["h5wasm", packages, "h5wasm/LICENSE.txt"], ["HDF5", ownFolder, "hdf5_licence.txt"], ["fflate", ownFolder, "fflate_licence.txt"], ["uPlot", packages, "uplot/LICENSE"]]
  .map(([name, folder, file]) => `${name}\n\n${read(path.join(folder, file)).trim()}`).join("\n\n").replace(/-(?=-)/g, "- ");
const parts = { licences, style: `${read(path.join(packages, "uplot/dist/uPlot.min.css"))}\n${read(style)}`, code: read(code) };
// A replacement function, since the texts contain $ signs.
const page = read(template).replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]);
fs.writeFileSync(out, page);
