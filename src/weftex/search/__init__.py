"""What several methods search windows with; structures of one method are in its package.

* `windows`: where whole windows lie in a sample; `window_kernels`: their distances
* `picture_kernels`: the picture in the making, its known pixels, coherent candidates
* `pyramid_windows`: windows over two levels of a pyramid, as vectors
* `approximate_nearest` and its kernels: kd-tree, quadtree pyramid, principal components
* `fft_mismatch`: differences of two pictures at every translation
"""
