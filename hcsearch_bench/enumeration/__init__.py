"""The bench `enumeration`: circuits of arrays against peers, and cost as n grows."""
