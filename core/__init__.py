"""The robot's perception and motion, without web, clock or asyncio; `README.md` here says where to begin."""
