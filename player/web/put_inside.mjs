// Puts a model, and a lesson if there is one, inside the page: node put_inside.mjs PAGE MODEL.h5 OUT.html [LESSON.json]
import fs from "node:fs";
import path from "node:path";
import zlib from "node:zlib";
import { elementsInside } from "./page/inside.mjs";

const [page, model, out, lesson] = process.argv.slice(2), text = fs.readFileSync(page, "utf8"), code = text.indexOf("<script>");  // the first: the code has this text, too
const base64 = zlib.gzipSync(fs.readFileSync(model), { level: 9 }).toString("base64");
const inside = elementsInside({ name: path.basename(model), base64, lesson: lesson && JSON.parse(fs.readFileSync(lesson, "utf8")) });
fs.writeFileSync(out, `${text.slice(0, code)}${inside}\n${text.slice(code)}`);
