// Runs an ONNX file on images with ONNX Runtime: node run.mjs NODE_MODULES MODEL.onnx IMAGES OUTPUTS, both raw float32.
// Prints the names and shapes of what goes in and comes out.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const [modules, model, images, outputs] = process.argv.slice(2);
const ort = createRequire(modules + '/')('onnxruntime-node');
const session = await ort.InferenceSession.create(model, { intraOpNumThreads: 1, interOpNumThreads: 1 });
const text = (all) => all.map((value) => `${value.name} ${value.type} ${value.shape.join(' ')}`).join('\n');
console.log(text(session.inputMetadata) + '\n' + text(session.outputMetadata));
const shape = session.inputMetadata[0].shape.slice(1);
const bytes = readFileSync(images);
const values = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const trials = values.length / shape.reduce((product, extent) => product * extent, 1);
const { outputs: made } = await session.run({ images: new ort.Tensor('float32', values, [trials, ...shape]) });
writeFileSync(outputs, Buffer.from(made.data.buffer, made.data.byteOffset, made.data.byteLength));
