"""Alembic's entry: runs the migrations in the connection and the transaction that `hcsearch.store.migrate` holds."""

from alembic import context

from hcsearch.store.schema import VERSION_TABLE, metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    version_table=VERSION_TABLE,
    render_as_batch=True,  # SQLite alters a table by copying it
)
with context.begin_transaction():
    context.run_migrations()
