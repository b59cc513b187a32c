"""`python -m softpuffer` is `puffer`."""

from .programs import puffer

puffer()
