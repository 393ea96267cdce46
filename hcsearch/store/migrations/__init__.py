"""Alembic migrations, run by `hcsearch.store.migrate`."""
