"""Code generated from proto/pliant/v1 at build time; the package `pliant` wraps it."""
