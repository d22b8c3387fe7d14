// onnxruntime's inference of a network of bench/nn/networks.hpp, BatchNorm folded into the convolution before it: writes
// the model by hand as protobuf (onnx.proto3, opset 13) and runs it on one thread or more.
// usage: onnxruntime.mjs NETWORK BATCH THREADS SECONDS; prints the version and samples/s of the best run, wall time.
// npm: onnxruntime-node (`npm install --ignore-scripts`: its script fetches GPU libraries), found through NODE_PATH.
import {createRequire} from 'node:module';

const networks = {
  NetA: {convs: [[2, 8, 'AveragePool'], [8, 16, 'AveragePool'], [16, 32, ''], [32, 32, '']], features: 32 * 27 * 27},
  NetB: {convs: [[2, 64, 'MaxPool'], [64, 64, 'MaxPool'], [64, 128, 'MaxPool'], [128, 128, 'GlobalAveragePool']],
    features: 128},
};

// Protobuf: a field is its number and wire type, then a varint or a length and bytes.
const varint = n => n < 128 ? [n] : [n % 128 + 128, ...varint(Math.floor(n / 128))];
const integer = (field, n) => Buffer.from([...varint(field * 8), ...varint(n)]);
const bytes = (field, ...parts) => {
  const body = Buffer.concat(parts.map(part => Buffer.from(part)));
  return Buffer.concat([Buffer.from([...varint(field * 8 + 2), ...varint(body.length)]), body]);
};

// AttributeProto: name, ints or i, type (7 INTS, 2 INT).
const ints = (name, values) => bytes(5, bytes(1, name), ...values.map(v => integer(8, v)), integer(20, 7));
const int = (name, value) => bytes(5, bytes(1, name), integer(3, value), integer(20, 2));
const node = (type, inputs, output, ...attributes) =>
  bytes(1, ...inputs.map(i => bytes(1, i)), bytes(2, output), bytes(4, type), ...attributes);
const values = count => Float32Array.from({length: count}, (_, i) => (i * 7919 % 1000) * 0.0002 - 0.09);
const tensor = (name, dims) => bytes(5, ...dims.map(d => integer(1, d)), integer(2, 1), bytes(8, name),
  bytes(9, values(dims.reduce((a, b) => a * b)).buffer));
// ValueInfoProto of a float tensor.
const value = (field, name, dims) => bytes(field, bytes(1, name),
  bytes(2, bytes(1, integer(1, 1), bytes(2, ...dims.map(d => bytes(1, integer(1, d)))))));

function model({convs, features}, batch) {
  const nodes = [], weights = [];
  let last = 'input';
  const add = (type, inputs, ...attributes) => {
    nodes.push(node(type, [last, ...inputs], last = `${type}${nodes.length}`, ...attributes));
  };
  convs.forEach(([source, filters, pool], i) => {
    weights.push(tensor(`w${i}`, [filters, source, 3, 3]), tensor(`b${i}`, [filters]));
    add('Conv', [`w${i}`, `b${i}`], ints('kernel_shape', [3, 3]), ints('pads', [1, 1, 1, 1]));
    add('Relu', []);
    if (pool === 'GlobalAveragePool') add(pool, []);
    else if (pool) add(pool, [], ints('kernel_shape', [2, 2]), ints('strides', [2, 2]));
  });
  add('Flatten', []);
  weights.push(tensor('fw', [7, features]), tensor('fb', [7]));
  add('Gemm', ['fw', 'fb'], int('transB', 1));
  const graph = bytes(7, ...nodes, bytes(2, 'network'), ...weights, value(11, 'input', [batch, 2, 110, 110]),
    value(12, last, [batch, 7]));
  return Buffer.concat([integer(1, 8), graph, bytes(8, integer(2, 13))]);  // IR version 8, opset 13
}

const require = createRequire(import.meta.url);
const onnx = require('onnxruntime-node');
const [name, batch, threads, seconds] = [process.argv[2], ...process.argv.slice(3).map(Number)];
const session = await onnx.InferenceSession.create(model(networks[name], batch),
  {intraOpNumThreads: threads, interOpNumThreads: 1, graphOptimizationLevel: 'all'});
const feeds = {input: new onnx.Tensor('float32', values(batch * 2 * 110 * 110), [batch, 2, 110, 110])};
for (let i = 0; i < 3; ++i) await session.run(feeds);
let best = Infinity;
for (const end = performance.now() + seconds * 1000; performance.now() < end;) {
  const start = performance.now();
  await session.run(feeds);
  best = Math.min(best, performance.now() - start);
}
console.log(require('onnxruntime-node/package.json').version, batch / best * 1000);
