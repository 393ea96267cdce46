"""The bench `folding`: designs that fold, joined from half-chains, against listing all circuits and filtering them."""
