"""The drawings of the paper's figures."""
