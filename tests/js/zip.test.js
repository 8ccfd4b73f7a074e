// A zip of what a person chose is one that other programs read.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { crc32, zipOf } from "../../static/js/ui/zip.js";

test("the checksum is CRC-32's", () => {
  assert.equal(crc32(new TextEncoder().encode("123456789")), 0xcbf43926);
});

test("Python reads the members back", async () => {
  const members = [
    { name: "map.yaml", bytes: new TextEncoder().encode("image: map.pgm\n") },
    { name: "Büro.pgm", bytes: new Uint8Array([80, 53, 0, 255, 10]) },
  ];
  const file = join(mkdtempSync(join(tmpdir(), "zip-")), "map.zip");
  writeFileSync(file, Buffer.from(await zipOf(members).arrayBuffer()));
  const reads = `import zipfile, sys; b = zipfile.ZipFile(sys.argv[1]); print(b.testzip(), [(n, list(b.read(n))) for n in b.namelist()])`;
  const told = execFileSync("python3", ["-c", reads, file], { encoding: "utf8" });
  const wanted = members.map(({ name, bytes }) => `('${name}', [${[...bytes].join(", ")}])`).join(", ");
  assert.equal(told.trim(), `None [${wanted}]`);
});
