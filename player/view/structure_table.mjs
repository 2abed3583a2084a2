// Prints the tables of the page's structures.js (names of structures and what they do) as C++: node structure_table.mjs FILE.js
import { readFileSync } from "node:fs";

const source = readFileSync(process.argv[2], "utf8");
for (const [list, table] of [["knownBundles", "known_bundles"], ["knownParts", "known_parts"]]) {
  const [, rows] = source.match(new RegExp(`const ${list} = \\[\\n(.*?)\\n\\];`, "s"));
  console.log(`constexpr KnownStructure ${table}[] = {`);
  for (const row of rows.split("\n")) {
    const [, pattern, texts] = row.match(/^ {2}\[\/(.*)\/i?, (".*", ".*")\],$/);
    console.log(`    {${JSON.stringify(pattern)}, ${texts}},`);
  }
  console.log("};");
}
