"""Understanding: words to commands or refusals."""
