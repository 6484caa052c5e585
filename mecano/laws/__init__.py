"""Laws: scalar functions with exact derivatives, shared by every element that needs one."""
