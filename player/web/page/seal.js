// Checks of a file's bytes before HDF5 reads them: the HDF5 signature, and the seal of schemas/motion-model.md.
import { ModelError } from "./model_error.js";

/// Largest file. Far above any knee, well below the memory limit of a page.
export const largestFileMb = 400;

const signature = [0x89, 0x48, 0x44, 0x46, 0x0d, 0x0a, 0x1a, 0x0a];
const sealName = "VRDASEAL";
const sealLength = 16;

/// CRC-32 as in zlib.
export function crc32(bytes) {
  const table = Array.from({ length: 256 }, (_, n) => {
    let c = n;
    for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
    return c >>> 0;
  });
  let crc = 0xffffffff;
  for (const byte of bytes) crc = table[(crc ^ byte) & 0xff] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

/// Throws ModelError unless the bytes may be an undamaged HDF5 file.
export function checkBytes(bytes) {
  if (bytes.length === 0) throw new ModelError("The file is empty, wanted a motion model (.h5) that vrda run wrote.");
  if (!signature.every((byte, i) => bytes[i] === byte)) throw new ModelError("This is not an HDF5 file, wanted a motion model (.h5) that vrda run wrote.");
  if (bytes.length < sealLength) throw new ModelError("The file is cut off.");
  const seal = bytes.subarray(bytes.length - sealLength);
  if (![...sealName].every((letter, i) => seal[i] === letter.charCodeAt(0))) return;
  const stored = new DataView(seal.buffer, seal.byteOffset + 8, 4).getUint32(0, true);
  if (stored !== crc32(bytes.subarray(0, bytes.length - sealLength))) throw new ModelError("The file is damaged: its bytes do not match its seal. Copy it again.");
}
