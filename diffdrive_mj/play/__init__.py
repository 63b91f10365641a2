"""`diffdrive play`: robot and belief on a page with sliders, the same physics stepped in the browser."""
