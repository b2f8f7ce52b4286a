"""How gently small pushes are answered."""
