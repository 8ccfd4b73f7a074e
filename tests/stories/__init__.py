"""Tests in counted time: it is the whole process's, so no console that really runs may live beside them."""
