"""Models of the user's own: ONNX files of known layouts, run by OpenCV."""
