"""x."""
def pages():
    """x."""
    return {"verification.md": "# Verification\n"}
