"""The kernels as WebAssembly, for the page and for static sites (docs/decisions/024-webassembly.md).

`entries` names what is exported, `build` compiles it (``make wasm``), `sources` tells whether the
file in the package is that of the kernels as they stand.
"""
